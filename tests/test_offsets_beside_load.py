"""Along one small motion offsets of the torque channels and a payload are much the same: the mass is then as uncertain as offsets leave it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from tests.serial_arms import Joint, swinging, urdf

pytestmark = pytest.mark.slow

JOINTS = (
    Joint("0 0 1", mass=8.0, length=0.25), Joint("0 1 0", "0 0 0.15", mass=7.0, length=0.4), Joint("0 1 0", "0 0 0.4", mass=4.0)
)  # fmt: skip
MORE = 1.2  # kg at the middle of the last link
OFFSETS = np.array([0.3, -0.6, 0.5])  # N m


def run(number: int, reach: float) -> pid.Recording:
    """Twenty seconds by pinocchio of an arm with friction, rotors and a heavier last link, none of which its description has."""
    rng, time = np.random.default_rng(number), np.arange(0.0, 20.0, 0.004)
    heavy = (*JOINTS[:2], replace(JOINTS[2], mass=JOINTS[2].mass + MORE))
    q, v, tau = swinging(rng, time, heavy, reach, (0.3, 3.1), np.array([1.5, 1.6, 0.7]))
    friction = np.array([9.0, 10.0, 5.0]) * v / np.hypot(v, 0.004) + np.array([7.0, 8.0, 4.0]) * v
    tau += friction + OFFSETS + np.array([0.8, 0.9, 0.5]) * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=str(number))


@pytest.mark.parametrize(("number", "reach", "most"), [(1, 0.1, 1.0), (2, 0.1, 1.0), (3, 0.1, 1.0), (4, 0.25, 0.2)])
def test_a_mass_is_as_uncertain_as_offsets_leave_it(number: int, reach: float, most: float, tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(urdf(JOINTS))
    found = pid.diagnose_motion(pid.Model.described(pid.load_robot(tmp_path / "arm.urdf")), [run(number, reach)])
    (load,) = (one for one in found.findings if one.effect in ("payload", "link_inertia"))
    low, high = load.parameters[0].change_interval95
    assert load.parameters[0].name == "mass"
    assert low <= MORE <= high, repr(found)
    assert high - low < most
    told = [value for one in found.findings if one.effect == "torque_offset" for value in one.parameters]
    assert {value.joint for value in told} == {1, 2, 3}
    assert all(v.change_interval95[0] <= OFFSETS[v.joint - 1] <= v.change_interval95[1] for v in told), repr(found)
