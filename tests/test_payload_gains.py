"""A drive gain that is another one in the recordings with a load is named, and friction of another day is not taken for one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from tests.conftest import UR10E_COLUMNS, UR10E_GAINS
from tests.plant import Arm, hide, multisine, point_to_point, record

pytestmark = pytest.mark.slow

MASS = 2.6
JOINTS = (1, 2, 3, 4, 5, 6)


def _recording(arm: Arm, seed: int, motion=multisine) -> pid.Recording:
    r = record(arm, motion(seed=seed, duration=20.0), seed=seed, step=2e-3)
    return pid.Recording(r.time, r.q, r.effort, "torque", dq=r.dq, source=f"seed {seed}")


@pytest.fixture(scope="module")
def estimate(ur5: pid.Robot) -> pid.Estimate:
    return pid.identify(ur5, [_recording(Arm(), 1), _recording(Arm(), 2, point_to_point)])


@pytest.fixture(scope="module")
def loaded() -> pid.Recording:
    return _recording(hide(Arm(), "payload", (), MASS), 3)


def scaled(recording: pid.Recording, joint: int | None, factor: float) -> pid.Recording:
    gains = (
        np.full(recording.n, factor) if joint is None else np.where(np.arange(1, recording.n + 1) == joint, factor, 1)
    )
    return replace(recording, effort=recording.effort * gains)


def holds(found: pid.Payload, mass: float) -> bool:
    return bool(found.mass_interval[0] < mass < found.mass_interval[1])


@pytest.mark.parametrize("factor", [0.85, 1.2])
@pytest.mark.parametrize("joint", [None, *JOINTS])
def test_a_gain_that_changed_with_the_load_is_no_confident_mass(
    estimate: pid.Estimate, loaded: pid.Recording, joint: int | None, factor: float
) -> None:
    """Either the change is stated, or the mass does not depend on it."""
    found = pid.identify_payload(estimate, scaled(loaded, joint, factor))
    assert found.contradictions or holds(found, MASS)
    if joint in (None, 1, 2, 3):  # the wrist's own links weigh next to nothing
        where = "all joints" if joint is None else f"joint {joint}"
        assert found.gain_change.joint == joint
        assert f"the torque of {where} is" in found.contradictions[0]
        assert found.as_dict()["mass_interval_kg"] is None
        assert "verdict: doubtful" in repr(found)
    if joint is None:
        low, high = found.gain_change.interval
        assert low - 0.03 < factor < high + 0.03
        assert not holds(found, MASS)  # the case for which it is there


def test_friction_of_another_day_contradicts_nothing(estimate: pid.Estimate, loaded: pid.Recording) -> None:
    more = (2.0, 2.0, 1.5, 0.5, 0.4, 0.3)  # a quarter of what the arm has
    warm = hide(hide(Arm(), "viscous_friction", JOINTS, more), "payload", (), MASS)
    for recording in (loaded, _recording(warm, 4)):
        found = pid.identify_payload(estimate, recording)
        assert found.contradictions == ()
        assert holds(found, MASS)
    assert (found.sigma / found.arm_sigma).max() > 2  # the residual did grow, and new friction explains why
    assert (found.friction_of_the_day.sigma / found.arm_sigma).max() < 2
    np.testing.assert_allclose(found.friction_of_the_day.mass, MASS, rtol=0.02)


def test_on_a_real_arm(data: Path) -> None:
    """Loads of a UR10e contradict nothing; with a fifth less or more gain than before they do, wherever the mass is wrong."""
    folder = data / "ur10e"
    robot = pid.load_robot(folder / "ur10e.urdf")
    estimate = pid.identify(robot, pid.load_recordings(folder / "ur-20_02_*.csv", UR10E_COLUMNS, UR10E_GAINS))
    for name, mass in (("13-load_2600", 2.6), ("31-load", None), ("31-unload", None)):
        recording = pid.load_recording(folder / f"ur-20_01_{name}.csv", UR10E_COLUMNS, UR10E_GAINS)
        found = pid.identify_payload(estimate, recording)
        assert found.contradictions == ()
        assert mass is None or holds(found, mass)
        for factor in (0.8, 1.25):
            (first, *_) = pid.identify_payload(estimate, scaled(recording, None, factor)).contradictions
            assert "the torque of all joints is" in first
