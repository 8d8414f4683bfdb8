"""Planned sessions: powers against simulated statistics, motions against every limit, choices against all choices."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import yaml
from scipy.stats import f as f_distribution

import physident as pid
from physident.diagnosis.next_session.resume import Resumed
from physident.diagnosis.next_session.saved_session import SavedExpectation
from physident.diagnosis.next_session.settled import Answer
from physident.effects.friction import CoulombFriction, StribeckFriction
from physident.effects.mounting import JointZeroOffset
from physident.excitation.detectability import EVIDENCE, Noise
from physident.excitation.limits.robot_limits import with_limits
from physident.excitation.motion.motion import Motion
from physident.excitation.motion.point_to_point import PointToPoint
from physident.excitation.motion.robot_programs import joint_trajectory_of, urscript_of
from physident.excitation.motion.sequence import MotionSequence
from physident.excitation.motion.trajectory import random_trajectory
from physident.excitation.session.choice import choose
from physident.excitation.session.evidence import ENOUGH, Evidence, _power_of_f
from physident.excitation.session.first import assumed_noise
from physident.excitation.session.loads import with_load
from physident.excitation.session.pieces import cell_of, make_pieces
from physident.excitation.session.plan import Budget, plan_session
from physident.excitation.session.questions import Expectation, OpenQuestion
from physident.excitation.session.ranges import ranges_of
from physident.excitation.session.ranking import rank_recordings
from physident.excitation.session.session import Outlook, Session
from tests.bad_input.good import URDF

SIGMA = 0.2  # N m


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    file = tmp_path_factory.mktemp("robots") / "arm.urdf"
    file.write_text(URDF)
    return pid.load_robot(file)


@pytest.fixture(scope="module")
def noise(arm: pid.Robot) -> Noise:
    return Noise(sigma=np.full(arm.n, SIGMA), worth=np.full(arm.n, 2.0), filter=pid.Filter())


@pytest.fixture(scope="module")
def questions() -> tuple[OpenQuestion, ...]:
    stribeck = StribeckFriction((1,), (0.1,))
    return (
        OpenQuestion(kind="rival", effect=stribeck, rivals=(CoulombFriction((1,)),), sizes=(0.4,)),
        OpenQuestion(kind="value", effect=CoulombFriction((2,)), sizes=(0.5,), std=0.2),
        OpenQuestion(kind="unseen", effect=StribeckFriction((2,), (0.1,))),
    )


def test_the_power_is_that_of_simulated_regressions() -> None:
    """A column of known energy in white noise: how often the gain in fit exceeds the evidence that a diagnosis requires."""
    rng = np.random.default_rng(1)
    samples, size = 60, 4.2
    column = np.zeros(samples + 1)
    column[0] = 1.0
    y = size * column + rng.standard_normal((20_000, samples + 1))
    before, after = (y**2).sum(axis=1), (y[:, 1:] ** 2).sum(axis=1)
    found = np.mean(samples * np.log(before / after) > EVIDENCE)
    assert _power_of_f(size**2, 1, samples) == pytest.approx(found, abs=0.012)
    threshold = samples * np.expm1(EVIDENCE / samples)
    assert _power_of_f(0.0, 1, samples) == pytest.approx(f_distribution.sf(threshold, 1, samples), rel=1e-6)
    powers = [_power_of_f(x, 2, 30) for x in (0, 1, 5, 20, 100, 2000)]
    assert all(a < b for a, b in itertools.pairwise(powers))
    assert 0 <= powers[0] < powers[-1] <= 1


def test_noncentrality_is_what_least_squares_leaves_of_the_column(arm, noise, questions) -> None:
    model = pid.Model.nominal(arm)
    evidence = Evidence(model, noise, questions[:1])
    motion = random_trajectory(arm, 3, base_frequency=0.1, duration=20.0)
    shown = evidence.shown(motion)
    time, q, v, a = motion.sample(125.0)
    signals = pid.Signals(time, q, v, a, np.zeros_like(q), rate=125.0, cutoff=noise.filter.cutoff)
    regressor = pid.build_regressor(arm, [*model.effects, questions[0].effect], [signals], noise.filter, model=model)
    Y = regressor.Y.reshape(-1, len(regressor.columns))
    others = Y[:, :-1] / np.maximum(np.linalg.norm(Y[:, :-1], axis=0), 1e-300)
    left = Y[:, -1] - others @ np.linalg.lstsq(others, Y[:, -1], rcond=1e-9)[0]
    memory = regressor.kept_rate / 2.0
    expected = 0.4**2 * float(left @ left) / SIGMA**2 / memory
    assert evidence.noncentralities(shown)[0] == pytest.approx(
        expected, rel=0.02
    )  # the ridge takes nearly dependent columns for dependent
    assert (shown + shown).samples == pytest.approx(2 * shown.samples)


def test_a_session_keeps_its_time_and_every_limit(arm, noise, questions) -> None:
    budget = Budget(minutes=2.5, limits="joint", seed=4, pool=8)
    session = plan_session(pid.Model.nominal(arm), questions, noise, budget)
    assert session.duration <= 150
    assert [leg.role for leg in session.legs].count("holdout") == 1
    assert session.legs[0].role == "warm-up"
    starts = [leg.trajectory.states(np.array([0.0, leg.trajectory.duration])) for leg in session.legs]
    for leg, ends in zip(session.legs, starts, strict=True):
        assert leg.trajectory.violations(arm) == []
        np.testing.assert_allclose(
            ends.q, np.tile(starts[0].q[0], (2, 1)), atol=1e-9
        )  # one after the other, without a move
        np.testing.assert_allclose(ends.v, 0, atol=1e-9)
    again = plan_session(pid.Model.nominal(arm), questions, noise, budget)
    assert repr(again) == repr(session)
    outlook = session.outlook
    assert outlook is not None
    assert [one.question for one in outlook.expectations[:3]] == [one.text for one in questions]
    minutes, settled = np.array(outlook.curve).T
    assert (np.diff(minutes) > 0).all()
    assert settled[-1] == pytest.approx(outlook.settled, abs=0.3)
    assert "expected to be settled" in repr(session)


def test_an_arm_that_is_slow_or_has_nothing_open_still_gets_a_session(arm, noise) -> None:
    slow = pid.Model.nominal(with_limits(arm, "speed=0.1 acceleration=0.05"))
    for minutes, load in ((0.75, None), (1.0, 1.0)):
        session = plan_session(slow, (), noise, Budget(minutes=minutes, limits="joint", pool=6, load=load))
        assert session.duration <= 60 * minutes + 1e-6
        assert [leg.role for leg in session.legs if not leg.loaded].count("fit") >= 2
        assert all(leg.trajectory.violations(slow.robot) == [] for leg in session.legs)
    with pytest.raises(pid.InputError, match="one with the load"):
        Budget(minutes=0.75, load=1.0)


def test_what_no_motion_shows_is_no_question(arm, noise) -> None:
    """A joint about the vertical: gravity does not change with its angle, so its zero is never seen."""
    unseen = [
        OpenQuestion(kind="unseen", effect=one) for one in (JointZeroOffset((1,)), StribeckFriction((2,), (0.1,)))
    ]
    session = plan_session(pid.Model.nominal(arm), unseen, noise, Budget(minutes=1.0, limits="joint", pool=6))
    assert session.outlook is not None
    assert [one.effect for one in session.outlook.expectations if one.kind == "unseen"] == ["stribeck_friction"]
    assert "no motion within the limits shows, by joint: joint zero offset (1)" in session.outlook.notes


def test_a_planned_session_shows_more_than_random_ones_of_as_many_pieces(arm, noise, questions) -> None:
    model = pid.Model.nominal(arm)
    budget = Budget(minutes=1.0, limits="joint", seed=4, pool=10)
    session = plan_session(model, questions, noise, budget)
    evidence = Evidence(model, noise, questions)
    cell = cell_of(model, None, "joint", None, 0.02, None, 4)
    shown = [evidence.shown(piece.motion) for piece in make_pieces(cell, 10, False, 5)]
    total = shown[0]
    for one in shown[1:]:
        total = total + one
    evidence.sized_by(total)

    def share(parts) -> float:
        together = parts[0]
        for one in parts[1:]:
            together = together + one
        needed = np.array([evidence._at_power(k, together.samples, ENOUGH) for k in range(len(questions))])
        return float(np.minimum(evidence.noncentralities(together) / needed, 1).mean())

    fitted = [evidence.shown(leg.trajectory) for leg in session.legs if leg.role == "fit"]
    random = [share(some) for some in itertools.combinations(shown, len(fitted))]
    assert share(fitted) > np.quantile(random, 0.8)


def test_a_load_is_carried_last_and_within_the_torque_limits(arm, noise, questions) -> None:
    model = pid.Model.nominal(arm)
    session = plan_session(model, questions, noise, Budget(minutes=2.0, limits="joint", seed=4, pool=6, load=1.5))
    assert [leg.loaded for leg in session.legs] == [False] * (len(session.legs) - 1) + [True]
    assert session.duration <= 120
    assert session.outlook is not None
    assert "drive-gains" in session.outlook.notes[-1]
    time = np.arange(0, 15, 0.02)
    states = replace(session.legs[-1].trajectory.states(time), rate=50.0)
    extra = with_load(model, 1.5).torque(states) - model.torque(states)
    x, y, z = arm.tool
    body = pin.Inertia(1.5, np.array([x, y, z]), np.zeros((3, 3)))  # the load, added to the last link by pinocchio
    heavy, bare = arm.pinocchio.copy(), arm.pinocchio.copy()
    heavy.inertias[arm.n] += body
    for k in (100, 300, 600):
        state = states.q[k], states.v[k], states.a[k]
        expected = pin.rnea(heavy, heavy.createData(), *state) - pin.rnea(bare, bare.createData(), *state)
        np.testing.assert_allclose(extra[k], expected, atol=1e-9)


def test_choices_are_within_the_budget_and_near_the_best() -> None:
    rng = np.random.default_rng(7)
    for _ in range(5):
        parts = list(rng.uniform(0, 1, (9, 4)))
        seconds = rng.uniform(5, 20, 9)

        def score(chosen: list[np.ndarray]) -> float:  # concave, as shares of what is needed are
            return float(np.minimum(np.sum(chosen, axis=0) if chosen else np.zeros(4), 1.2).sum())

        picked = choose(parts, seconds.tolist(), 45.0, score)
        assert seconds[picked].sum() <= 45.0 + 1e-6
        assert len(set(picked)) == len(picked)
        every = (s for n in range(10) for s in itertools.combinations(range(9), n) if seconds[list(s)].sum() <= 45.0)
        best = max(score([parts[i] for i in some]) for some in every)
        assert score([parts[i] for i in picked]) >= 0.9 * best


def test_programs_have_the_set_points_of_the_motion() -> None:
    motion: Motion = random_trajectory(pid.load_robot("ur5"), 1, base_frequency=0.2)
    time, q, v, a = motion.sample(50.0)
    data = yaml.safe_load(joint_trajectory_of(motion, ["a", 'b "c"', "d", "e", "f", "on"], 50.0))
    assert data["joint_names"][1] == 'b "c"'
    assert data["joint_names"][5] == "on"  # a plain word would be true
    since = [p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in data["points"]]
    np.testing.assert_allclose(since, time, atol=1e-8)
    for name, values in (("positions", q), ("velocities", v), ("accelerations", a)):
        np.testing.assert_allclose([p[name] for p in data["points"]], values, atol=1e-8)
    script = urscript_of("01 a", motion, 50.0)
    rows = [[float(x) for x in row.split(",")] for row in re.findall(r"servoj\(\[([^\]]+)\], t=0.02", script)]
    np.testing.assert_allclose(rows, q, atol=1e-8)
    assert script.startswith("def motion_01_a():")
    assert script.rstrip().endswith("motion_01_a()")
    fast = urscript_of("x", motion, 2000.0)
    assert "t=0.002," in fast  # no controller takes set points faster than 500 Hz


def test_a_sequence_is_its_parts() -> None:
    first = PointToPoint(np.array([[0.0, 0.0], [0.5, 0.2], [0.0, 0.0]]), 1.0, 2.0)
    second = replace(first, points=-first.points)
    both = MotionSequence((first, second), pause=0.5)
    assert both.duration == pytest.approx(2 * first.duration + 1.0)
    np.testing.assert_allclose(both.states(np.array([1.0])).q, first.states(np.array([1.0])).q)
    at = first.duration + 0.5 + 1.0
    np.testing.assert_allclose(both.states(np.array([at])).q, -both.states(np.array([1.0])).q)
    assert both.extent().lower[0] == pytest.approx(-0.5)
    with pytest.raises(pid.InputError):
        MotionSequence(())


def test_limits_become_tighter_and_never_wider(arm) -> None:
    tight = with_limits(arm, "speed=0.5 acceleration=1,2 torque=1e6 lower=-1")
    assert (tight.velocity_limit <= 0.5).all()
    assert tight.acceleration_limit == (1.0, 2.0)
    np.testing.assert_array_equal(tight.torque_limit, np.minimum(arm.torque_limit, 1e6))
    np.testing.assert_array_equal(tight.lower, np.maximum(arm.lower, -1))
    np.testing.assert_array_equal(tight.nominal, arm.nominal)
    for bad in ("speed", "fast=1", "speed=1,2,3", "speed=-1", "speed=nan", "lower=2 upper=1", ""):
        with pytest.raises(pid.InputError):
            with_limits(arm, bad)


def test_a_recording_that_repeats_another_is_used_last(arm) -> None:
    """Two different motions, and each of them again: the second of either adds least."""
    filter, model = pid.Filter(), pid.Model.nominal(arm)
    regressors = []
    for seed in (1, 1, 2, 2):
        time, q, v, a = random_trajectory(arm, seed, base_frequency=0.1, duration=20.0).sample(125.0)
        signals = pid.Signals(time, q, v, a, np.zeros_like(q), rate=125.0, cutoff=filter.cutoff)
        regressors.append(pid.build_regressor(arm, model.effects, [signals], filter, model=model))
    for criterion in ("prediction", "d_optimal"):
        order = rank_recordings(regressors, np.ones(arm.n), criterion)
        assert sorted(order) == [0, 1, 2, 3]
        assert {order[0] // 2, order[1] // 2} == {0, 1}
    with pytest.raises(pid.InputError):
        rank_recordings(regressors, np.ones(arm.n), "best")


def test_a_model_whose_joints_twist_can_be_planned_for(ur5: pid.Robot) -> None:
    """The torque of a torsion needs derivatives over time, which instants without a rate do not have."""
    stiff = pid.Model.nominal(ur5, ("rigid_body", "joint_elasticity"))
    twisting = replace(
        stiff, theta=np.where([c.effect == "joint_elasticity" for c in stiff.columns], 1e-4, stiff.theta)
    )
    motion = random_trajectory(ur5, 3)
    loads = [ranges_of(one, motion).size[2] for one in (stiff, twisting)]
    np.testing.assert_allclose(*loads, rtol=1e-9)  # of inertia and gravity, which do not twist
    assert np.isfinite(assumed_noise(twisting, None)[0].sigma).all()


@pytest.mark.parametrize(("kept", "pays"), [(8, True), (0, False)])
def test_the_promise_of_a_session_after_one_that_kept_nothing_is_not_believed(kept, pays) -> None:
    """Ten questions, each to be settled with a power of 0.8: a session that kept its promise of eight is followed by one that
    promises the same, one that settled none by one that promises no answer."""
    asked = {"kind": "unseen", "question": "?", "effect": "torque_offset", "joints": (1,), "power": 0.8, "detail": ""}
    then = {**asked, "rival": "", "rival_joints": (), "parameter": 0, "size": 1.0, "smallest": 0.5}
    answers = [Answer(question=SavedExpectation(**then), settled=k < kept, text="") for k in range(10)]
    outlook = Outlook(
        expectations=(Expectation(**asked, smallest=0.5),) * 10, curve=((0.0, 0.0), (1.0, 8.0)), load=None, noise=""
    )
    none: Any = None
    said = Resumed(
        answers=tuple(answers), diagnosis=none, estimate=None, pooled=0, next=Session((), (), outlook=outlook)
    )
    assert said.expected == pytest.approx(8.0)
    assert said.promised == pytest.approx(8.0 if pays else 8.0 / 9.0)
    assert said.pays == pays
