"""The identifiability table says what is known of an upright UR5, and agrees with what identification can find."""

from __future__ import annotations

import pytest

import physident as pid
from tests.test_identify import _recording


@pytest.fixture(scope="module")
def table(ur5: pid.Robot) -> pid.Identifiability:
    filter = pid.Filter()
    return pid.measure_identifiability(ur5, [pid.prepare(_recording(ur5, k, 0.3), filter) for k in (1, 2)], filter)


def test_an_upright_ur5_hides_what_it_must(table: pid.Identifiability) -> None:
    for joint in (1, 6):
        assert table.share("joint_zero_offset", (joint,), "new") == 0
        assert table.share("joint_zero_offset", (joint,), "refitted") == 0
    for joint in (1, 2):  # inside the rigid columns, but not when those are held
        assert table.share("rotor_inertia", (joint,), "refitted") < 1e-6
        assert table.share("rotor_inertia", (joint,), "new") == 1
    for joint in (3, 4, 5, 6):
        assert table.share("rotor_inertia", (joint,), "refitted") > 0.01
    assert table.share("payload", (), "refitted") < 1e-6
    assert table.share("payload", (), "new") == 1


def test_every_effect_and_joint_has_its_cell(table: pid.Identifiability) -> None:
    names = {cell.effect for cell in table.cells}
    assert names == set(pid.CATALOGUE) - {"rigid_body"}
    assert len([c for c in table.cells if c.effect == "coulomb_friction"]) == 6
    assert all(0 <= c.refitted <= 1 for c in table.cells)
    assert "verdict" in repr(table)


def test_a_ripple_says_the_band_it_needs(table: pid.Identifiability) -> None:
    (cell,) = [c for c in table.cells if c.effect == "torque_ripple" and c.joints == (4,)]
    assert cell.cutoff > 0
