"""Planned motions: derivatives, rest at both ends, limits, files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.excitation.motion.motion import Motion
from physident.excitation.motion.point_to_point import PointToPoint
from tests.robots import TREE

STEP = 1e-5  # s


def moves() -> PointToPoint:
    return PointToPoint(np.array([[0.0, 0.5], [1.2, 0.1], [1.2, 0.1], [1.25, 0.15], [-1.0, 0.0]]), 0.8, 2.0, 0.3)


def some_motions(ur5: pid.Robot) -> list[Motion]:
    return [pid.random_trajectory(ur5, seed=4, harmonics=4, base_frequency=0.25, duration=8.0), moves()]


def test_velocity_and_acceleration_are_the_derivatives(ur5):
    for motion in some_motions(ur5):
        time = np.random.default_rng(0).uniform(0.01, motion.duration - 0.01, 400)
        before, here, after = (motion.states(time + d) for d in (-STEP, 0.0, STEP))
        np.testing.assert_allclose((after.q - before.q) / (2 * STEP), here.v, atol=2e-5)
        smooth = (np.abs(after.a - before.a) < 0.1).all(axis=1)  # not across a corner of a trapezoid
        assert smooth.mean() > 0.95
        np.testing.assert_allclose(((after.v - before.v) / (2 * STEP))[smooth], here.a[smooth], atol=1e-6)


def test_starts_and_ends_at_rest(ur5):
    for motion in some_motions(ur5):
        ends = motion.states(np.array([-1.0, 0.0, motion.duration, motion.duration + 1.0]))
        assert np.abs(ends.v).max() < 1e-12
        assert np.abs(ends.a).max() < 1e-11
        np.testing.assert_allclose(ends.q[0], ends.q[1], atol=1e-14)
        np.testing.assert_allclose(ends.q[2], ends.q[3], atol=1e-14)


def test_rest_is_the_nearest_and_what_breaks_it_is_told():
    rng = np.random.default_rng(1)
    a, b = rng.standard_normal((2, 3, 5))
    given = pid.Trajectory(a, b, np.zeros(3), 0.2, 11.0)
    rest = given.to_rest()
    assert not given.at_rest
    assert rest.at_rest
    assert rest.duration == pytest.approx(10.0)
    order = np.arange(1, 6)
    for change, normal in ((given.a - rest.a, order), (given.b - rest.b, order**2)):
        # the shortest way onto a plane is along its normal
        np.testing.assert_allclose(change, np.outer(change[:, 0], normal) / normal[0], atol=1e-12)
    assert not pid.Trajectory(rest.a, rest.b, rest.q0, 0.2, 11.0).at_rest


@pytest.mark.parametrize("seed", range(4))
def test_random_trajectories_stay_inside_the_limits(ur5, seed, tmp_path):
    file = tmp_path / "tree.urdf"
    file.write_text(TREE)
    for robot in (ur5, pid.load_robot(file)):
        motion = pid.random_trajectory(robot, seed, harmonics=2 + seed, base_frequency=0.1 * (1 + seed), scale=1.0)
        assert motion.violations(robot) == []
        _, q, v, a = motion.sample(2000.0)
        acceleration = np.array(robot.acceleration_limit or [np.pi] * robot.n)
        assert (q >= robot.lower - 1e-9).all()
        assert (q <= robot.upper + 1e-9).all()
        assert (np.abs(v) <= robot.velocity_limit + 1e-9).all()
        assert (np.abs(a) <= acceleration + 1e-9).all()
        # and it uses them: some limit of each joint is reached
        used = np.maximum(
            np.abs(a).max(axis=0) / acceleration, np.abs(v).max(axis=0) / np.minimum(robot.velocity_limit, np.pi)
        )
        used = np.maximum(used, np.ptp(q, axis=0) / (np.minimum(robot.upper, np.pi) - np.maximum(robot.lower, -np.pi)))
        assert (used > 0.98).all()


def test_extent_bounds_every_instant(ur5):
    for motion in some_motions(ur5):
        extent = motion.extent()
        _, q, v, a = motion.sample(5000.0)
        for reached, bound in (
            (q.max(axis=0), extent.upper),
            (-q.min(axis=0), -extent.lower),
            (np.abs(v).max(axis=0), extent.speed),
            (np.abs(a).max(axis=0), extent.acceleration),
        ):
            assert (reached <= bound + 1e-9).all()
            np.testing.assert_allclose(reached, bound, rtol=2e-3, atol=1e-3)


def test_a_motion_beyond_a_limit_names_joint_and_limit(ur5):
    inside = pid.random_trajectory(ur5, 0, scale=0.9)
    fast = pid.Trajectory(1.5 * inside.a, 1.5 * inside.b, inside.q0, 0.1, 10.0)
    assert any("joint 1 reaches a" in text and "3.142" in text for text in fast.violations(ur5))
    far = pid.Trajectory(inside.a, inside.b, inside.q0 + 9 * np.eye(6)[2], 0.1, 10.0)
    assert len(far.violations(ur5)) == 1
    assert "joint 3 goes from" in far.violations(ur5)[0]
    assert "2 joints" in moves().violations(ur5)[0]


def test_point_to_point_has_trapezoidal_speed():
    motion = moves()
    _, q, v, a = motion.sample(1000.0)
    assert np.abs(v).max() == pytest.approx(0.8, abs=1e-3)
    assert np.abs(a).max() == pytest.approx(2.0)
    np.testing.assert_allclose(q[-1], [-1.0, 0.0], atol=1e-12)
    # a long move: distance over speed, and one ramp; no time for the move that goes nowhere; a short one: two ramps
    expected = 5 * 0.3 + (1.2 / 0.8 + 0.4) + 2 * np.sqrt(0.05 / 2.0) + (2.25 / 0.8 + 0.4)
    assert motion.duration == pytest.approx(expected)
    moving = np.abs(v) > 1e-9
    assert (moving[:, 0] == moving[:, 1]).all()


def test_sample_and_csv(ur5, tmp_path):
    motion = pid.random_trajectory(ur5, 0, base_frequency=0.2)
    time, q, v, a = motion.sample(125.0)
    assert len(time) == 626
    assert time[-1] == 5.0
    motion.write_csv(tmp_path / "plan.csv", 125.0)
    lines = (tmp_path / "plan.csv").read_text().splitlines()
    joints = range(1, 7)
    assert lines[0].split(",") == ["time", *(f"{c}_{j}" for c in ("q", "dq", "ddq") for j in joints)]
    table = np.loadtxt(tmp_path / "plan.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(table, np.column_stack([time, q, v, a]), atol=1e-9)
    for rate in (0.0, np.nan, 1e12):
        with pytest.raises(pid.InputError, match="rate"):
            motion.sample(rate)


def test_files_round_trip(ur5, tmp_path):
    for motion in some_motions(ur5):
        motion.save(tmp_path / "plan.json")
        again = pid.load_trajectory(tmp_path / "plan.json")
        assert type(again) is type(motion)
        for one, other in zip(motion.sample(50.0), again.sample(50.0), strict=True):
            np.testing.assert_array_equal(one, other)
    assert json.loads((tmp_path / "plan.json").read_text())["schema"] == "physident.trajectory/1"


GOOD = {
    "schema": "physident.trajectory/1",
    "a": [[1, 2]],
    "b": [[1, 2]],
    "q0": [0],
    "base_frequency": 0.1,
    "duration": 10,
}


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[1, 2]",
        "{",
        json.dumps({**GOOD, "schema": "physident.model/1"}),
        json.dumps({**GOOD, "a": [[1, "x"]]}),
        json.dumps({**GOOD, "a": [[1, 2], [3]]}),
        json.dumps({**GOOD, "b": [[1, 2, 3]]}),
        json.dumps({**GOOD, "q0": []}),
        json.dumps({**GOOD, "q0": None}),
        json.dumps({**GOOD, "base_frequency": 0}),
        json.dumps({**GOOD, "duration": "long"}),
        json.dumps({**GOOD, "duration": float("nan")}),
        json.dumps({**GOOD, "colour": "red"}),
        json.dumps({**GOOD, "kind": "spline"}),
        json.dumps({**GOOD, "kind": []}),
        json.dumps({key: value for key, value in GOOD.items() if key != "b"}),
        json.dumps(
            {"schema": GOOD["schema"], "kind": "point_to_point", "points": [[0, 0]], "speed": 1, "acceleration": 1}
        ),
        json.dumps(
            {"schema": GOOD["schema"], "kind": "point_to_point", "points": [[0], [1]], "speed": 0, "acceleration": 1}
        ),
    ],
)
def test_bad_files_are_one_clear_line(text: str, tmp_path: Path):
    file = tmp_path / "plan.json"
    file.write_text(text)
    with pytest.raises(pid.InputError) as caught:
        pid.load_trajectory(file)
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "settings", [{"harmonics": 1}, {"scale": 1.5}, {"scale": np.nan}, {"base_frequency": -1}, {"duration": 12.0}]
)
def test_random_trajectory_refuses_what_cannot_be(ur5, settings):
    with pytest.raises(pid.InputError):
        pid.random_trajectory(ur5, 0, **settings)
