"""A motion that covers what a learned curve has not seen: it goes there, and leaves less of the curve open than any other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.effects.learned.curves import LearnedLoad, LearnedPosition, LearnedTime
from physident.effects.learned.velocity_curve import LearnedVelocity
from physident.excitation.criterion.covering import Covering
from physident.excitation.design_covering import _continued, _curves, _random_states
from physident.excitation.task import task_of

pytestmark = pytest.mark.slow

QUICK: dict[str, Any] = {"limits": "joint", "harmonics": 3, "starts": 1, "generations": 8, "seed": 3}
NOISE = 0.3  # N m


@pytest.fixture(scope="module")
def estimate(ur5: pid.Robot) -> pid.Estimate:
    """An arm that was recorded in a small part of its ranges."""
    model = pid.Model.nominal(ur5)
    runs = []
    for seed in (1, 2):
        motion = pid.random_trajectory(ur5, seed=seed, base_frequency=0.1, duration=20.0, scale=0.25)
        run = pid.simulate(model, motion, seed=seed)
        runs.append(
            replace(run, effort=run.effort + NOISE * np.random.default_rng(seed).standard_normal(run.effort.shape))
        )
    curves = (LearnedPosition((2, 4)), LearnedVelocity((3,)))
    return pid.identify(ur5, runs, effects=[*model.effects, *curves])


def left_open(estimate: pid.Estimate, motion: pid.Trajectory, joint: int) -> float:
    """Mean variance, in units of the prior, of a curve over the joint's whole speed after a motion, by Bayes' rule on its samples."""
    robot, fastest = estimate.model.robot, float(estimate.model.robot.velocity_limit[joint - 1])
    curve = LearnedVelocity((joint,), (-fastest,), (fastest,), (1.0,))
    v = motion.states(np.arange(0, motion.duration, 0.05)).v[:, joint - 1]
    seen, wanted = curve.shapes_at(robot, v), curve.shapes_at(robot, np.linspace(-fastest, fastest, 101))
    posterior = np.linalg.inv(np.eye(seen.shape[1]) + seen.T @ seen / 0.05**2)
    prior = (wanted**2).sum(axis=1)
    return float(np.mean(np.einsum("sk,kl,sl->s", wanted, posterior, wanted) / prior))


def test_the_motion_goes_where_the_curve_was_not_and_leaves_less_of_it_open(estimate: pid.Estimate) -> None:
    found = pid.design_covering(estimate, "learned_velocity", **QUICK)
    (one,) = found.covered
    assert one.joint == 3
    assert one.before[1] < 0.5 * one.possible[1]  # what was recorded
    assert one.reached[0] < 0.8 * one.possible[0]
    assert one.reached[1] > 0.8 * one.possible[1]
    v = found.design.trajectory.states(np.linspace(0.0, found.design.trajectory.duration, 4001)).v[:, 2]
    np.testing.assert_allclose(
        one.reached, (v.min(), v.max()), rtol=1e-2
    )  # the motion's own, without what was seen before
    assert one.gap is None
    assert replace(one, reached=(one.before[1] + 0.5, one.before[1] + 1.0)).gap == (one.before[1], one.before[1] + 0.5)
    plain = pid.design_trajectory(estimate, base_frequency=0.1, periods=2, **QUICK)
    assert left_open(estimate, found.design.trajectory, 3) < left_open(estimate, plain.trajectory, 3)
    assert not found.design.trajectory.violations(estimate.model.robot)
    assert "recorded before" in repr(found)
    assert found.as_dict()["effect"] == "learned_velocity"


def test_curves_of_several_joints_are_covered_together_or_one_alone(estimate: pid.Estimate) -> None:
    both = pid.design_covering(estimate, "learned_position", **QUICK)
    assert [one.joint for one in both.covered] == [2, 4]
    assert max(np.ptp([one.reached, one.before]) / np.ptp(one.before) for one in both.covered) > 1.2
    alone = pid.design_covering(estimate, "learned_position", 4, **QUICK)
    assert [one.joint for one in alone.covered] == [4]


def test_what_is_known_counts_no_more() -> None:
    """The gradient is that of the value, and it is flat where everything is known."""
    rng = np.random.default_rng(1)
    root = rng.standard_normal((6, 9))
    G, known = root @ root.T, np.diag([1.0, 2.0, 3.0, 1e9, 1e9, 1e9])
    criterion = Covering(known)
    value, slope = criterion.gradient(G)
    for _ in range(5):
        change = rng.standard_normal((6, 6))
        change = change + change.T
        ends = [float(criterion.values(G + sign * 1e-5 * change)) for sign in (-1, 1)]
        assert (ends[1] - ends[0]) / 2e-5 == pytest.approx(np.vdot(slope, change), rel=1e-4, abs=1e-9)
    assert np.abs(slope[3:, 3:]).max() < 1e-8 * np.abs(slope).max()
    assert value == criterion.values(G)


def test_a_plain_design_is_one_for_the_laws(estimate: pid.Estimate) -> None:
    """Curves need no motion that shows all their numbers: the prior decides the rest."""
    names = [c.effect for c in estimate.model.columns]
    assert {names[i] for i in task_of(estimate).chosen}.isdisjoint({"learned_position", "learned_velocity"})


@pytest.mark.parametrize(
    ("effect", "joint", "text"),
    [
        ("learned_load", None, "the model has no learned curve learned_load; expected learned_position on joint 2 or"),
        ("learned_position", 3, "the model has no learned curve learned_position on joint 3"),
        ("coulomb_friction", None, "the model has no learned curve coulomb_friction"),
    ],
)
def test_what_cannot_be_covered_is_said(estimate: pid.Estimate, effect: str, joint: int | None, text: str) -> None:
    with pytest.raises(pid.InputError, match=text):
        pid.design_covering(estimate, effect, joint, **QUICK)


def test_every_motion_covers_a_curve_over_time(ur5: pid.Robot) -> None:
    plain = pid.Model.nominal(ur5)
    curve = LearnedTime((1,), (0.0,), (20.0,), (1.0,))
    model = pid.Model(ur5, (*plain.effects, curve), np.concatenate([plain.theta, np.zeros(len(curve.columns(ur5)))]))
    with pytest.raises(pid.InputError, match="every motion covers"):
        _curves(model, "learned_time", None)


def test_loads_of_random_motions_say_how_far_a_curve_goes(ur5: pid.Robot, estimate: pid.Estimate) -> None:
    model = pid.Model.nominal(ur5)
    curve = LearnedLoad((2,), (-5.0,), (5.0,), (1.0,))
    wide = _continued(model, curve, _random_states(model))
    gravity = 2 * max(
        abs(pid.Model.nominal(ur5, ["rigid_body"]).torque(states)[:, 1]).max() for states in _random_states(model)
    )
    assert wide.high is not None
    assert 5.0 < wide.high[0] < gravity


def test_the_command_line_covers_and_refuses(
    estimate: pid.Estimate, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, out = tmp_path / "m.json", tmp_path / "motion.json"
    estimate.save(model)
    base = ["design", "--model", str(model), "--out", str(out), "--limits", "joint"]
    assert run([*base, "--cover", "learned_velocity", "--discriminate", "payload", "gravity_tilt"]) == 2
    assert "--discriminate and --cover were both given" in capsys.readouterr().err
    assert run(["design", "--robot", "ur5", "--cover", "learned_velocity", "--out", str(out)]) == 2
    assert "--cover was given with --robot" in capsys.readouterr().err
    assert not out.exists()
    assert run([*base, "--cover", "learned_velocity", "--joint", "3"]) == 0
    assert "Covers learned_velocity" in capsys.readouterr().out
    assert pid.load_trajectory(out).n == 6
