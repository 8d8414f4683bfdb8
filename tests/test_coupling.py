"""Coupled friction acts on both joints of a pair alike, and a gain on what a joint's own channel shows; torque that leaks from one channel
into another does neither."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.problem.candidates import candidate_effects
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.rivals.imitators import holds_against_leaks
from physident.diagnosis.search.candidate_scores import score_candidates
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.diagnosis.stability import stability
from physident.diagnosis.stability.stability import searched_in_halves
from physident.effects.transmission import CoupledFriction
from physident.estimation.identify import prepare_all
from physident.identifiability.base_parameters import random_motion
from physident.identifiability.identifiability import measure_identifiability
from tests.made_once import made_once
from tests.plant import Arm, hide, multisine
from tests.plant.laws import Dry
from tests.serial_arms import make_arm

pytestmark = pytest.mark.slow

SEEDS = (61, 63)
PAIR = (5, 6)


def dry() -> Arm:
    plain = Arm()
    return replace(plain, friction=replace(plain.friction, law=Dry()))


def leaking(recording: pid.Recording) -> pid.Recording:
    """A third of what the fifth channel shows stands in the sixth too."""
    effort = recording.effort.copy()
    effort[:, 5] += effort[:, 4] / 3
    return replace(recording, effort=effort)


def leaking_a_little(recording: pid.Recording) -> pid.Recording:
    """A hundredth of it."""
    effort = recording.effort.copy()
    effort[:, 5] += effort[:, 4] / 100
    return replace(recording, effort=effort)


def leaking_currents(recording: pid.Recording) -> pid.Recording:
    """The same torques as currents of drives, which no sensor measures."""
    return replace(leaking(recording), effort_kind="current", drive_gains=(1.0,) * 6)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("coupling")


def recorded(
    arm: Arm, folder: Path, name: str, change: Callable[[pid.Recording], pid.Recording] = lambda one: one
) -> list[pid.Recording]:
    """Two recordings of the arm of a name, which are made once, with a change of their channels."""
    return [change(made_once(folder / f"{name}_{seed}.csv", arm, multisine(seed), seed)) for seed in SEEDS]


def coupled() -> Arm:
    return hide(dry(), "coupled_friction", PAIR, 0.8 * float(Arm().friction.coulomb[5]))


def scaled() -> Arm:
    return hide(dry(), "torque_constant", (PAIR[1],), 0.3)


@pytest.mark.parametrize(
    ("name", "joints", "arm", "change", "holds"),
    [
        ("coupled_friction", PAIR, coupled, lambda one: one, True),
        ("coupled_friction", PAIR, dry, leaking, False),
        ("torque_constant", PAIR[1:], scaled, lambda one: one, True),
        ("torque_constant", PAIR[1:], dry, leaking, False),
        ("torque_constant", PAIR[1:], dry, leaking_currents, True),
    ],
    ids=("gears", "gears or channels", "gain", "gain or channels", "currents do not leak"),
)
def test_torque_that_leaks_is_no_coupling_and_no_gain(
    folder: Path,
    ur5: pid.Robot,
    name: str,
    joints: tuple[int, ...],
    arm: Callable[[], Arm],
    change: Callable[[pid.Recording], pid.Recording],
    holds: bool,
) -> None:
    recordings = recorded(arm(), folder, arm.__name__, change)
    estimate = pid.identify(ur5, recordings)
    problem = state_problem("missing", estimate, prepare_all(ur5, recordings, estimate.filter), estimate.filter, 0)
    hypothesis = settled_hypothesis(problem, ())
    (candidate,) = (c for c in hypothesis.data.candidates if (c.name, c.joints) == (name, joints))
    assert holds_against_leaks(hypothesis, candidate) is holds


@pytest.mark.parametrize(("arm", "holds"), [(scaled, True), (dry, False)], ids=("gain and leak", "leak"))
def test_a_leak_that_is_little_beside_a_wrong_gain_does_not_hide_it(
    folder: Path, ur5: pid.Robot, arm: Callable[[], Arm], holds: bool
) -> None:
    """The leak is beyond chance in what the gain leaves, where this is a hundredth of what the gain explains."""
    estimate = pid.identify(ur5, recorded(dry(), folder, "dry"))
    changed = recorded(arm(), folder, arm.__name__, leaking_a_little if holds else leaking)
    problem = state_problem("different", estimate, prepare_all(ur5, changed, estimate.filter), estimate.filter, 0)
    hypothesis = settled_hypothesis(problem, ())
    (candidate,) = (c for c in hypothesis.data.candidates if c.key == ("torque_constant", PAIR[1:]))
    assert holds_against_leaks(hypothesis, candidate) is holds


def test_halves_are_not_searched_for_what_the_whole_search_refused_as_a_leak(
    folder: Path, ur5: pid.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of what beats chance only: what is too little to be judged may show in a half."""
    arms = (("dry", dry()), ("stiffer", hide(dry(), "coulomb_friction", PAIR[0], 1.5)))
    runs = [one for name, arm in arms for one in recorded(arm, folder, name, leaking)]
    estimate = pid.identify(ur5, runs[:2])
    problem = state_problem("different", estimate, prepare_all(ur5, runs[2:], estimate.filter), estimate.filter, 0)
    first, pair = score_candidates(settled_hypothesis(problem, ())), ("coupled_friction", PAIR)
    every = searched_in_halves(first, ())
    assert pair in every
    judged = stability.is_not_imitated
    monkeypatch.setattr(stability, "is_not_imitated", lambda state, one: one.name != pair[0] and judged(state, one))
    assert every - searched_in_halves(first, ()) == {pair}
    assert searched_in_halves(first, (pair,)) == every


def test_torque_that_leaks_into_another_channel_is_named_with_its_share(folder: Path, ur5: pid.Robot) -> None:
    recordings = recorded(dry(), folder, "dry", leaking)
    found = pid.diagnose_motion(pid.identify(ur5, recordings), recordings)
    (cause,) = found.causes
    assert (cause.effect, cause.joints) == ("torque_crosstalk", (6,))
    shares = {value.name: value.value for value in cause.parameters}
    assert shares.pop("share_of_joint5") == pytest.approx(1 / 3, abs=0.03)


def test_torques_from_motor_currents_have_no_crosstalk(folder: Path, ur5: pid.Robot) -> None:
    """Sensors leak; a current that follows another joint's torque shows something else."""
    gains = (10.0, 10.0, 8.0, 5.0, 5.0, 5.0)
    currents = [
        replace(one, effort=one.effort / gains, effort_kind="current").with_drive_gains(gains)
        for one in recorded(dry(), folder, "dry", leaking)
    ]
    model, signals = pid.Model.nominal(ur5), [pid.prepare(one, pid.Filter(5.0)) for one in currents]
    assert "torque_crosstalk" not in {name for name, *_ in candidate_effects(model, signals)}
    table = measure_identifiability(ur5, signals, pid.Filter(5.0))
    assert not any(cell.new for cell in table.cells if cell.effect == "torque_crosstalk")
    by_sensor = [replace(one, from_currents=False) for one in signals]
    assert "torque_crosstalk" in {name for name, *_ in candidate_effects(model, by_sensor)}


def test_gears_that_couple_two_joints_are_no_crosstalk(folder: Path, ur5: pid.Robot) -> None:
    recordings = recorded(coupled(), folder, "coupled")
    found = pid.diagnose_motion(pid.identify(ur5, recordings), recordings)
    assert [(cause.effect, cause.joints) for cause in found.causes] == [("coupled_friction", PAIR)]


def test_a_joint_that_slides_shares_no_motor_with_one_that_turns(tmp_path: Path) -> None:
    """Where a quill slides between joints that turn, rad/s and m/s would have to be added; the same pairs of a planar arm are tried."""
    pairs = {}
    for name in ("scara", "seven"):
        (tmp_path / f"{name}.urdf").write_text(make_arm(name, "dry").urdf, encoding="utf-8")
        robot = pid.load_robot(tmp_path / f"{name}.urdf")
        model = pid.Model(robot, pid.make_effects(["viscous_friction"]), np.zeros(robot.n))
        tried = candidate_effects(model, [random_motion(robot, 0)])
        pairs[name] = [joints for effect, joints, options in tried if effect == "coupled_friction" and options]
        assert CoupledFriction().pairs(robot) == [(j - 1, k - 1) for j, k in pairs[name]]
    assert pairs == {"scara": [(1, 2)], "seven": [(1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (6, 7)]}
    with pytest.raises(pid.InputError, match=r"of joints \(2, 3\) of robot .* one turns and one slides"):
        CoupledFriction((2, 3)).pairs(pid.load_robot(tmp_path / "scara.urdf"))


def test_a_load_and_a_sensor_that_leaks_are_both_new_and_their_model_is_of_the_new_arm(
    folder: Path, ur5: pid.Robot
) -> None:
    """Each is a change of its own: neither may be held for old because the other one changed. And the model that holds both is no model of the
    recordings from before: beside it, the arm as it was has changed back."""
    before = recorded(dry(), folder, "dry")
    after = recorded(hide(dry(), "payload", (), 1.0), folder, "loaded", leaking)
    found = pid.diagnose_motion(pid.identify(ur5, before), after[:1])
    assert {(f.effect, f.joints) for f in found.causes} == {("payload", ()), ("torque_crosstalk", (6,))}
    assert {f.effect for f in found.missing_since_before}.isdisjoint({"payload", "torque_crosstalk"})
    assert found.estimate is not None
    assert {source.path for source in found.estimate.sources} == {after[0].source}
    back = pid.diagnose_motion(found.estimate, before[1:])
    assert {(f.effect, f.joints) for f in back.causes} == {("payload", ()), ("torque_crosstalk", (6,))}
    mass = next(f for f in back.causes if f.effect == "payload").parameters[0]
    assert mass.change == pytest.approx(-1.0, abs=0.05)


def test_effects_without_a_place_on_an_arm_leave_the_table_of_all_effects_whole(tmp_path: Path) -> None:
    (tmp_path / "scara.urdf").write_text(make_arm("scara", "dry").urdf, encoding="utf-8")
    robot = pid.load_robot(tmp_path / "scara.urdf")
    motion = random_motion(robot, 0)
    table = measure_identifiability(robot, [replace(motion, torque=0.1 * motion.v)], pid.Filter(5.0))
    assert [cell.joints for cell in table.cells if cell.effect == "coupled_friction"] == [(1, 2)]
    assert {cell.joints for cell in table.cells if cell.effect == "torque_crosstalk"} == {(1,), (2,), (3,), (4,)}
