"""Dry friction has grown and viscous friction fallen, so that along any motion little changes: both are named, though the parameters could take them up."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import physident as pid
from tests.serial_arms import Joint, swinging, urdf

pytestmark = pytest.mark.slow

JOINTS = (
    Joint("0 0 1", mass=8.0, length=0.25), Joint("0 1 0", "0 0 0.15", mass=7.0, length=0.4), Joint("0 1 0", "0 0 0.4", mass=4.0)
)  # fmt: skip
DRY, VISCOUS = np.array([9.0, 10.0, 5.0]), np.array([7.0, 8.0, 4.0])  # N m, N m s/rad


def run(number: int, dry: float = 1.0, viscous: float = 1.0) -> pid.Recording:
    """Twenty seconds by pinocchio; friction differs by 2 % from day to day, and that of joint 3 is so many times as large."""
    rng, time = np.random.default_rng(number), np.arange(0.0, 20.0, 0.004)
    q, v, tau = swinging(rng, time, JOINTS, 0.25, (0.3, 3.1))
    day, third = rng.normal(1.0, 0.02, 3), np.array([0, 0, 1])
    level = DRY * (1 + third * (dry - 1)) * v / np.sqrt(v**2 + 0.01**2)
    tau += day * (level + VISCOUS * (1 + third * (viscous - 1)) * v) + 0.4 * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=str(number))


@pytest.mark.parametrize(("dry", "viscous"), [(1.4, 0.5), (1.0, 1.0)])
def test_two_values_that_have_changed_are_no_wandering_parameters(dry: float, viscous: float, tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(urdf(JOINTS))
    own = [run(number) for number in (1, 2, 3, 4)]
    estimate = pid.identify(pid.load_robot(tmp_path / "arm.urdf"), own)
    found = pid.diagnose_motion(estimate, [run(number, dry, viscous) for number in (5, 6)], before=own)
    if dry == 1.0:
        assert found.causes == (), repr(found)
        return
    told = {one.effect: one for one in found.findings if one.grade != "hint"}
    assert set(told) == {"coulomb_friction", "viscous_friction"}, repr(found)
    assert {one.joints for one in told.values()} == {(3,)}
    changes = [told[name].parameters[0].change for name in ("coulomb_friction", "viscous_friction")]
    assert changes == pytest.approx([DRY[2] * (dry - 1), VISCOUS[2] * (viscous - 1)], rel=0.2)
