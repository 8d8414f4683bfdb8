"""Effects that make the same torque on any motion of an arm are rivals by construction, whatever the recordings prefer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.result.advice import other_rival
from physident.diagnosis.result.assemble import _joined
from physident.diagnosis.result.findings import Rival
from physident.diagnosis.rivals.rivals import check_rivals
from physident.diagnosis.rivals.same_torque import by_simpler, random_motion, same_torque
from physident.diagnosis.rivals.whole_friction import whole_friction
from physident.diagnosis.search.candidate_scores import score_candidates
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.diagnosis.search.hypothesis import AcceptedEffect, Hypothesis
from physident.estimation.identify import prepare_all
from tests.serial_arms import ARMS, Joint, urdf

Key = tuple[str, tuple[int, ...]]


def opened_planar(folder: Path, offset: float) -> Hypothesis:
    """Two joints with parallel axes whose first zero is wrong by an angle; the torque is pinocchio's."""
    path = folder / "planar.urdf"
    path.write_text(urdf(ARMS["two"]))
    robot, model = pid.load_robot(path), pin.buildModelFromXML(urdf(ARMS["two"]))
    time = np.arange(0.0, 30.0, 0.008)
    runs = []
    for seed in (1, 2, 3):
        rng = np.random.default_rng(seed)
        omega, phase = rng.uniform(0.8, 4.0, (4, 2)), rng.uniform(0, 2 * np.pi, (4, 2))
        angle = time[:, None, None] * omega + phase
        q, v, a = (
            0.5 * part.sum(axis=1) for part in (np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle))
        )
        true = q + np.array([offset, 0.0]) * (seed == 3)
        data = model.createData()
        tau = np.array([pin.rnea(model, data, *state) for state in zip(true, v, a, strict=True)])
        tau += 2.0 * v + 0.05 * rng.standard_normal(tau.shape)
        runs.append(pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"{seed}"))
    estimate = pid.identify(robot, runs[:2])
    signals = prepare_all(robot, runs[2:], estimate.filter)
    return settled_hypothesis(state_problem("different", estimate, signals, estimate.filter, 0), ())


def accepted(state: Hypothesis, *keys: Key) -> Hypothesis:
    found = {c.key: c for c in state.data.candidates}
    chosen = []
    for key in keys:
        effect = found[key].options[0].effect
        assert effect is not None
        chosen.append(AcceptedEffect(found[key], effect))
    return settled_hypothesis(state.problem, chosen)


@pytest.fixture(scope="module")
def planar(tmp_path_factory: pytest.TempPathFactory) -> Hypothesis:
    return opened_planar(tmp_path_factory.mktemp("planar"), 0.03)


def test_a_planar_arm_feels_a_tilt_as_a_wrong_zero() -> None:
    """What the search is to find, from pinocchio alone: gravity that is turned, and a first angle that is, pull alike."""
    model = pin.buildModelFromXML(urdf(ARMS["two"]))
    tilted = pin.buildModelFromXML(urdf(ARMS["two"]))
    c, s = np.cos(0.03), np.sin(0.03)
    tilted.gravity.linear = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) @ model.gravity.linear
    for q in np.random.default_rng(0).uniform(-2, 2, (20, 2)):
        turned = pin.computeGeneralizedGravity(model, model.createData(), q + np.array([0.03, 0.0]))
        pulled = pin.computeGeneralizedGravity(tilted, tilted.createData(), q)
        np.testing.assert_allclose(turned, pulled, atol=1e-9)


def test_a_tilt_of_a_planar_arm_is_a_rival_of_a_wrong_zero(planar: Hypothesis) -> None:
    state = accepted(planar, ("joint_zero_offset", (1,)))
    (one,) = state.accepted
    same = same_torque(state)[one.candidate.key]
    assert ("gravity_tilt", ()) in {c.key for c in same}
    checked = check_rivals(replace(score_candidates(state)), one, same)
    assert ("gravity_tilt", ()) in {c.key for c in checked.same}


def test_a_payload_that_stands_for_a_wrong_zero_has_it_as_rival(planar: Hypothesis) -> None:
    """A larger effect is no rival of a smaller one that it contains."""
    both = same_torque(accepted(planar, ("payload", ())))["payload", ()]
    assert {c.name for c in both} & {"joint_zero_offset", "gravity_tilt", "link_inertia"}
    assert "payload" not in {
        c.name for c in same_torque(accepted(planar, ("joint_zero_offset", (1,))))[("joint_zero_offset", (1,))]
    }


def test_presliding_over_no_distance_is_coulomb_friction(planar: Hypothesis) -> None:
    """The same friction by the distance, which is known better at reversals than the sign of velocity: the simpler name counts."""
    state = accepted(planar, ("joint_zero_offset", (1,)), ("presliding_hysteresis", (2,)))
    simpler, stands_for = by_simpler(state, same_torque(state))
    assert [one.candidate.key for one in simpler] == [("joint_zero_offset", (1,)), ("coulomb_friction", (2,))]
    assert stands_for == {("coulomb_friction", (2,)): ("presliding_hysteresis", (2,))}
    # over a distance that the joint moves within, it is something else
    far = state.accepted[1].candidate.options[-1].effect
    assert far is not None
    apart = settled_hypothesis(state.problem, [state.accepted[0], replace(state.accepted[1], effect=far)])
    assert by_simpler(apart, same_torque(apart)) == (apart.accepted, {})


def test_friction_has_no_such_rival(planar: Hypothesis) -> None:
    # with the wrong zero unexplained, what scales the friction of both joints would be hidden on the first by its error
    state = accepted(planar, ("joint_zero_offset", (1,)), ("viscous_friction", (2,)))
    assert same_torque(state)["viscous_friction", (2,)] == []


def test_the_motion_goes_through_the_recorded_ranges_and_is_no_recording(planar: Hypothesis) -> None:
    problem = planar.problem
    made, (given,) = random_motion(problem), problem.signals
    np.testing.assert_allclose(np.abs(made.q - (given.q.max(axis=0) + given.q.min(axis=0)) / 2).max(axis=0),
                               (given.q.max(axis=0) - given.q.min(axis=0)) / 2)  # fmt: skip
    step = made.time[1] - made.time[0]
    np.testing.assert_allclose(np.gradient(made.q, step, axis=0)[1:-1], made.v[1:-1], atol=0.02 * np.abs(made.v).max())
    np.testing.assert_allclose(np.gradient(made.v, step, axis=0)[1:-1], made.a[1:-1], atol=0.05 * np.abs(made.a).max())
    assert np.abs(np.corrcoef(*made.q.T).min()) < 0.5


def test_no_motion_is_designed_for_what_none_can_separate() -> None:
    rivals = (Rival("gravity_tilt", (), inseparable=True), Rival("torque_offset", (1,)))
    assert other_rival("joint_zero_offset", rivals) == rivals[1]
    assert other_rival("joint_zero_offset", rivals[:1]) is None
    keys = [(("torque_offset", (1,)), True), (("torque_offset", (2,)), False), (("gravity_tilt", ()), True)]
    assert _joined(keys) == (Rival("gravity_tilt", (), inseparable=True), Rival("torque_offset", (1, 2)))


def test_friction_that_grows_with_a_load_that_is_always_the_same_is_coulomb_friction(tmp_path: Path) -> None:
    """A slide that carries a weight up and down, slowly: the model has its Coulomb friction, of which there is now more."""
    text = urdf((Joint("0 0 1", mass=4.0, kind="prismatic"), Joint("0 1 0", mass=2.0)))
    path = tmp_path / "lift.urdf"
    path.write_text(text)
    robot, model = pid.load_robot(path), pin.buildModelFromXML(text)
    time = np.arange(0.0, 30.0, 0.008)
    runs = []
    for seed, level in ((1, 3.0), (2, 3.0), (3, 5.0)):
        rng = np.random.default_rng(seed)
        omega, phase = rng.uniform(0.4, 1.5, (3, 2)), rng.uniform(0, 2 * np.pi, (3, 2))
        angle = time[:, None, None] * omega + phase
        q, v, a = (
            0.1 * part.sum(axis=1) for part in (np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle))
        )
        data = model.createData()
        tau = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
        tau += 2.0 * v + np.array([level, 0.3]) * np.sign(v) + 0.2 * rng.standard_normal(tau.shape)
        runs.append(pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"{seed}"))
    estimate = pid.identify(robot, runs[:2])
    signals = prepare_all(robot, runs[2:], estimate.filter)
    opened = settled_hypothesis(state_problem("different", estimate, signals, estimate.filter, 0), ())
    state = accepted(opened, ("load_dependent_friction", (1,)))
    simpler, stands_for = by_simpler(state, same_torque(state))
    assert [one.candidate.key for one in simpler] == [("coulomb_friction", (1,))]
    assert stands_for == {("coulomb_friction", (1,)): ("load_dependent_friction", (1,))}
    turning = accepted(opened, ("load_dependent_friction", (2,)))  # whose load changes with every acceleration
    assert by_simpler(turning, same_torque(turning))[1] == {}


LIGHT = (
    Joint(mass=4.0),
    Joint(mass=0.02, length=0.05),
)  # what the second joint carries is hardly more than its friction


def rubbing(seed: int, share: float = 1.0, dry: float = 1.0, viscous: float = 1.0) -> pid.Recording:
    """Two joints whose friction gives way within a fifth of a milliradian (Maxwell slip) and grows with speed; of the second joint all of it is
    so many times (``share``) as large, of the first one its ``dry`` and its ``viscous`` part."""
    model, time = pin.buildModelFromXML(urdf(LIGHT)), np.arange(0.0, 30.0, 0.008)
    rng = np.random.default_rng(seed)
    omega, phase = rng.uniform(0.8, 4.0, (4, 2)), rng.uniform(0, 2 * np.pi, (4, 2))
    angle = time[:, None, None] * omega + phase
    q, v, a = (0.4 * part.sum(axis=1) for part in (np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle)))
    data, stretched = model.createData(), np.zeros(q.shape)
    for k in range(1, len(q)):
        stretched[k] = np.clip(stretched[k - 1] + q[k] - q[k - 1], -2e-4, 2e-4)
    tau = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
    tau += 4000.0 * stretched * np.array([dry, share]) + 0.5 * v * np.array([viscous, share])
    tau += 0.02 * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"{seed}")


@pytest.fixture(scope="module")
def light(tmp_path_factory: pytest.TempPathFactory) -> pid.Estimate:
    path = tmp_path_factory.mktemp("light") / "light.urdf"
    path.write_text(urdf(LIGHT))
    return pid.identify(pid.load_robot(path), [rubbing(1), rubbing(2)])


@pytest.mark.parametrize(("joint", "share"), [(2, 1.25), (2, 0.8), (1, 1.25)])
def test_a_motor_of_a_joint_that_carries_friction_alone_is_its_friction_by_another_name(
    light: pid.Estimate, joint: int, share: float
) -> None:
    signals = prepare_all(light.model.robot, [rubbing(3, share)], light.filter)
    state = settled_hypothesis(state_problem("different", light, signals, light.filter, 0), ())
    found = whole_friction(accepted(state, ("torque_constant", (joint,))))
    if joint == 1:  # gravity is most of what this one carries
        assert found == {}
    else:
        assert found[("torque_constant", (2,))].share == pytest.approx(share - 1, abs=0.03)


@pytest.mark.parametrize(("viscous", "one_change"), [(1.33, True), (1.2, False), (0.67, False)])
def test_friction_of_every_kind_that_has_grown_is_one_change(
    light: pid.Estimate, viscous: float, one_change: bool
) -> None:
    """Of a joint that carries gravity: a third more dry and viscous friction is one story or two, and the one is told first; a third more of the
    one and less of the other are two. So are a third and a fifth more, which is nearly one change, where recordings tell them apart."""
    own = [rubbing(1), rubbing(2)]
    answer = pid.diagnose_motion(light, [rubbing(3, dry=1.33, viscous=viscous)], before=own)
    dry, speed = sorted(answer.causes, key=lambda one: one.effect == "viscous_friction")
    assert (dry.joints, speed.joints, speed.effect) == ((1,), (1,), "viscous_friction")
    assert {dry.effect, *(one.effect for one in dry.rivals)} >= {"coulomb_friction"}
    assert speed.parameters[0].change == pytest.approx(0.5 * (viscous - 1), rel=0.05)
    told = " ".join(repr(answer).split())
    for one in (dry, speed):
        assert (Rival("friction_level", (1,), True) in one.rivals) is one_change
    if one_change:
        assert "from before: friction_level (joint 1) or " in told
        assert "it may be one change: 33 % more of every kind of friction of joint 1" in told


def test_more_friction_of_every_kind_is_named_where_a_motor_is(light: pid.Estimate) -> None:
    answer = pid.diagnose_motion(light, [rubbing(3, 1.25)])
    (first,) = answer.causes
    assert first.joints == (2,)
    assert first.effect == "torque_constant"
    assert first.rivals[0] == Rival("friction_level", (2,), True)
    assert "Nearly all torque of joint 2 is friction: 25 % more of every kind" in first.advice
    assert "torque_constant (joint 2) or friction_level (joint 2)" in " ".join(repr(answer).split())
