"""Motions that tell rivals apart: the criterion by an independent projection, the predicted magnitude by a diagnosis' count."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.effects.friction import CoulombFriction
from physident.excitation.detectability import EVIDENCE, Noise, detectable_magnitudes
from physident.excitation.motion.series import Series
from physident.excitation.recording_session import slowed
from physident.excitation.rival_effects import rivals_of, task_of_rivals
from physident.excitation.task import task_of
from tests.robots import TREE


@pytest.fixture(scope="module")
def arm(ur5) -> pid.Model:
    return pid.Model.nominal(ur5)


def test_separation_is_the_part_outside_baseline_and_rival(arm):
    """Against least squares on the stacked columns, term by term."""
    rivals = rivals_of(arm, "stribeck_friction", "load_dependent_friction", 3)
    task, criterion = task_of_rivals(rivals, task_of(arm))
    series = Series(6, 4, 0.1)
    y = 0.4 * np.random.default_rng(0).standard_normal(series.size)
    information = task.information(series, 64)
    Y, b = information.regressor(y), criterion.baseline
    expected = []
    for term in criterion.terms:
        beside = Y[:, [*range(b), *(b + k for k in term.rival)]]
        own = Y[:, [b + k for k in term.effect]]
        rest = own - beside @ np.linalg.lstsq(beside, own, rcond=None)[0]
        expected.append(-0.5 * np.log(np.linalg.det(rest.T @ rest)) / own.shape[1])
    assert float(criterion.values(information.matrix(y))) == pytest.approx(np.mean(expected), rel=1e-3)
    assert len(criterion.terms) == 4  # three shapes of one, one of the other
    gradient = information.pullback(y, criterion.gradient(information.matrix(y))[1])
    d = np.random.default_rng(1).standard_normal(series.size)

    def central(h):
        sides = [criterion.gradient(information.matrix(y + s * d))[0] for s in (h, -h)]
        return (sides[0] - sides[1]) / (2 * h)

    assert gradient @ d == pytest.approx((4 * central(1e-5) - central(2e-5)) / 3, rel=1e-5)


def test_what_is_told_apart_leaves_the_baseline(arm):
    rivals = rivals_of(arm, "coulomb_friction", "load_dependent_friction", 2)
    left = {c.joint for c in rivals.reduced_model.columns if c.effect == "coulomb_friction"}
    assert left == {1, 3, 4, 5, 6}
    assert rivals.reduced_model.parameters("coulomb_friction")[1] == arm.parameters("coulomb_friction")[2]
    assert rivals_of(arm, "payload", "torque_constant").joints == (1, 2, 3, 4, 5, 6)
    assert rivals_of(arm, "coupled_friction", "coulomb_friction").joints == (1, 2, 3, 4, 5)
    for a, b, joint, text in (
        ("payload", "payload", None, "given twice"),
        ("rust", "payload", None, "'rust' cannot be separated"),
        ("contact", "payload", None, "'contact' cannot"),
        ("link_inertia", "payload", 6, "joint 6 has no link_inertia"),
    ):
        with pytest.raises(pid.InputError, match=text):
            rivals_of(arm, a, b, joint)


def test_a_joint_on_which_one_of_the_two_shows_nothing_does_not_end_the_design(arm):
    """The zero of a joint about the vertical, beside a link of a model that is held: of these nothing is fitted there."""
    motion = pid.random_trajectory(arm.robot, 3, base_frequency=0.1)
    noise = Noise(sigma=np.full(6, 0.2), worth=np.full(6, 2.0), filter=pid.Filter())
    found = detectable_magnitudes(arm, rivals_of(arm, "joint_zero_offset", "link_inertia"), motion, noise)
    zeros = {one.joint: one.magnitude for one in found if one.effect == "joint_zero_offset"}
    assert zeros[1] == np.inf
    assert 0 < zeros[2] < 0.1
    links = [one.magnitude for one in found if one.effect == "link_inertia" and one.joint == 1]
    assert 0 < min(links) < np.inf


def test_a_change_of_a_link_shows_beside_a_model_that_is_held(arm):
    rivals = rivals_of(arm, "payload", "torque_constant", 2)
    assert rivals.model_fixed
    task, criterion = task_of_rivals(rivals, task_of(arm))
    assert criterion.baseline == 0
    assert len(task.chosen) == 11
    motion = pid.random_trajectory(arm.robot, 3, base_frequency=0.1)
    noise = Noise(sigma=np.full(6, 0.5), worth=np.full(6, 10.0), filter=pid.Filter())
    found = detectable_magnitudes(arm, rivals, motion, noise)
    mass = next(one for one in found if one.parameter == "payload_mass")
    assert 0.001 < mass.magnitude < 0.5  # kg, by 0.5 N m of noise at an arm's length


def test_least_magnitude_is_where_evidence_reaches_what_is_asked(arm):
    """An effect of just that size leaves, where the rival is fitted instead, a residual worth the evidence."""
    rivals = rivals_of(arm, "coulomb_friction", "load_dependent_friction", 2)
    motion = pid.random_trajectory(arm.robot, 3, base_frequency=0.1, duration=20.0)
    filter = pid.Filter()
    noise = Noise(sigma=np.full(6, 0.5), worth=np.full(6, 10.0), filter=filter)
    found = detectable_magnitudes(arm, rivals, motion, noise)[0]
    assert (found.effect, found.joint) == ("coulomb_friction", 2)
    time, q, v, a = motion.sample(125.0)
    signals = arm.refer(pid.Signals(time, q, v, a, rate=125.0, cutoff=filter.cutoff))
    effects = [*rivals.reduced_model.effects, *rivals.on("load_dependent_friction", 2)]
    torque = np.zeros_like(q)
    torque[:, 1] = found.magnitude * np.tanh(v[:, 1] / 0.01)
    rows = pid.build_regressor(arm.robot, effects, [replace(signals, torque=torque)], filter, model=arm)
    Y, tau = rows.Y.reshape(-1, len(rows.columns)), rows.torque.ravel()
    rest = tau - Y @ np.linalg.lstsq(Y, tau, rcond=1e-10)[0]
    memory = rows.kept_rate / 10.0
    samples = len(rows.time) * 6 / memory
    evidence = samples * np.log1p(float(rest @ rest) / 0.25 / memory / samples)
    assert evidence == pytest.approx(EVIDENCE, rel=1e-2)


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> pid.Robot:
    file = tmp_path_factory.mktemp("robots") / "tree.urdf"
    file.write_text(TREE)
    return pid.load_robot(file)


def test_a_design_shows_smaller_magnitudes(tree):
    rivals = ("coulomb_friction", "load_dependent_friction", 3)
    found = pid.design_discriminating(tree, *rivals, "joint", 3, noise=0.5, starts=1, generations=4)
    assert all(one.margin > 0 for one in found.design.margins)
    ours = np.prod([one.magnitude for one in found.detectable])
    usual = np.prod([one.usual for one in found.detectable])
    assert ours < usual / 2
    assert "torque, tool, table and links were not checked" in repr(found).partition("verdict: ")[2]
    everything = replace(found, design=replace(found.design, limits="all"))
    assert "verdict: every limit holds" in repr(everything)
    assert "not checked" not in repr(everything)
    with pytest.raises(pid.InputError, match="how much torque noise"):
        pid.design_discriminating(tree, *rivals, "joint")


def test_a_session_has_what_a_diagnosis_splits_by(tree):
    session = pid.design_session(tree, load=1.5, harmonics=2, starts=1, generations=2, limits="joint")
    fitted = [leg for leg in session.legs if not leg.holdout]
    assert len(fitted) == 8
    assert {(leg.speed, leg.loaded) for leg in fitted} == {(s, x) for s in (1.0, 0.5) for x in (True, False)}
    assert sum(leg.holdout for leg in session.legs) == 1
    assert all(leg.trajectory.duration >= 15 for leg in session.legs)
    for leg in session.legs:  # each begins and ends at rest
        np.testing.assert_allclose(leg.trajectory.states(np.array([0.0, leg.trajectory.duration])).v, 0.0, atol=1e-9)
    assert all(leg.trajectory.violations(tree) == [] for leg in session.legs)
    fast, slow = session.designs[0].trajectory, slowed(session.designs[0].trajectory, 0.5)
    a, b = fast.states(np.array([1.3])), slow.states(np.array([2.6]))
    np.testing.assert_allclose(a.q, b.q)
    np.testing.assert_allclose(a.v, 2 * b.v)
    np.testing.assert_allclose(a.a, 4 * b.a)
    refused: tuple[dict[str, Any], ...] = ({"load": -1.0}, {"speeds": (1.0,)}, {"speeds": (1.0, 2.0)}, {"motions": 1})
    for bad in refused:
        with pytest.raises(pid.InputError):
            pid.design_session(tree, **bad)


def test_rivals_of_an_identified_model_keep_the_settings_of_their_joints(arm):
    """``identify`` finds a width for each joint; the effect on some joints has the widths of these."""
    widths = (0.01, 0.02, 0.03, 0.04, 0.05, 0.06)
    effects = tuple(replace(e, smoothing=widths) if e.name == "coulomb_friction" else e for e in arm.effects)
    rivals = rivals_of(pid.Model(arm.robot, effects, arm.theta), "coulomb_friction", "load_dependent_friction", 2)
    (left,) = (e for e in rivals.reduced_model.effects if isinstance(e, CoulombFriction))
    assert left.joints == (1, 3, 4, 5, 6)
    assert left.smoothing == (0.01, 0.03, 0.04, 0.05, 0.06)
    (there,) = rivals.variants[0]
    assert isinstance(there, CoulombFriction)
    assert (there.joints, there.smoothing) == ((2,), (0.02,))
    (on_joint,) = rivals.on("coulomb_friction", 2)
    assert isinstance(on_joint, CoulombFriction)
    assert (on_joint.joints, on_joint.smoothing) == ((2,), (0.02,))
    assert len(rivals.reduced_model.theta) == len(arm.theta) - 1


def test_what_needs_more_torque_than_the_drive_has_does_not_show(arm):
    """A spring's torque is its stiffness times the largest angle; ten times the noise asks for ten times as much."""
    motion = pid.random_trajectory(arm.robot, 3, base_frequency=0.1)
    _, q, _, _ = motion.sample(125.0)
    rivals = rivals_of(arm, "joint_spring", "torque_ripple", 6)
    limit = arm.robot.torque_limit[5]
    said = []
    for sigma in (0.02, 0.2, 2.0, 20.0, 200.0):
        noise = Noise(sigma=np.full(6, sigma), worth=np.full(6, 2.0), filter=pid.Filter())
        (spring,) = (one for one in detectable_magnitudes(arm, rivals, motion, noise) if one.effect == "joint_spring")
        needed = spring.magnitude * np.abs(q[:, 5]).max()
        said.append(spring.beyond is not None)
        assert said[-1] == (needed > limit)
        if spring.beyond is not None:
            assert spring.beyond == pytest.approx(needed, rel=0.05)
    assert said[0] is False
    assert said[-1] is True
