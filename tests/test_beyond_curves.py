"""Beyond what a learned curve was learned from: a simulation says so, and friction goes on as it was."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.effects.learned.curves import LearnedPosition
from physident.effects.learned.velocity_curve import LearnedVelocity
from physident.recordings.signals import Signals
from tests.serial_arms import ARMS, swung, urdf


def test_a_motion_beyond_a_curve_is_told(ur5: pid.Robot) -> None:
    motion = pid.random_trajectory(ur5, seed=1, base_frequency=0.2, duration=5.0)
    states = motion.states(np.linspace(0.0, motion.duration, 2001))
    q, v = states.q[:, 1], states.v[:, 2]
    middle, fastest = (q.min() + q.max()) / 2, np.abs(v).max()
    for share in (1.0, 0.5):
        half = share * np.ptp(q) / 2
        curves = [
            LearnedPosition((2,), (middle - half,), (middle + half,), (1.0,)),
            LearnedVelocity((3,), (-share * fastest,), (share * fastest,), (1.0,)),
        ]
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            pid.simulate(pid.Model.nominal(ur5, ["rigid_body", *curves]), motion)
        texts = [str(one.message) for one in said]
        if share == 1.0:
            assert texts == []
            continue
        told = ("joint 2 leaves what learned_position was", "joint 3 leaves what learned_velocity was")
        for text, start, reached in zip(texts, told, (q, v), strict=True):
            assert text.startswith(start)
            ends = [float(x) for x in text.split(": ")[1].split(" rad")[0].split(" to ")]
            assert ends == pytest.approx([reached.min(), reached.max()], abs=0.05)  # a controller follows it nearly


def hump(speed: np.ndarray) -> np.ndarray:
    """Friction [N m] that rises to 2.5 at 0.8 rad/s and falls again: no law of the catalogue."""
    return 2.5 * np.sign(speed) * np.exp(-(((np.abs(speed) - 0.8) / 0.4) ** 2)) * np.tanh(np.abs(speed) / 0.05)


@pytest.mark.slow
def test_a_faster_joint_has_the_friction_of_curve_and_laws_together(tmp_path: Path) -> None:
    """The data say nothing of how a curve shares a line with viscous friction, and beyond the curve that must not show."""
    (tmp_path / "two.urdf").write_text(urdf(ARMS["two"]))
    runs = []
    for seed in (1, 2, 3):
        rng, time = np.random.default_rng(seed), np.arange(0.0, 20.0, 0.005)
        q, v, tau = swung(rng, time)
        tau += np.array([4.0, 2.5]) * np.tanh(v / 0.01) + np.array([3.0, 2.0]) * v
        tau[:, 0] += hump(v[:, 0])
        tau += 0.1 * rng.standard_normal(tau.shape)
        runs.append(pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=str(seed)))
    found = pid.diagnose_motion(pid.identify(pid.load_robot(tmp_path / "two.urdf"), runs), runs)
    assert ("learned_velocity", (1,)) in {(f.effect, f.joints) for f in found.causes}
    assert found.estimate is not None
    model = found.estimate.model
    top = max(float(np.abs(run.dq[:, 0]).max()) for run in runs if run.dq is not None)
    v = np.column_stack([np.array([0.8, 1.1, 1.3, -1.1, -1.3]) * top, np.zeros(5)])
    at_rest, moving = (model.refer(Signals.of_states(0 * v, one, 0 * v)) for one in (0 * v, v))
    friction = (model.measured_torque(moving) - model.measured_torque(at_rest))[:, 0]
    np.testing.assert_allclose(friction, 4 * np.sign(v[:, 0]) + 3 * v[:, 0] + hump(v[:, 0]), rtol=0.12)
