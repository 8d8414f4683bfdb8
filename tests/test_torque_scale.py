"""Recordings whose torques are all scaled are told as one thing, and not as heavier links with more friction."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.rivals.imitators import scales_as_a_whole
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.effects.scales.torque_scale import TorqueScale
from physident.estimation.identify import prepare_all
from physident.testing import check_effect
from tests.made_once import made_once
from tests.plant import Arm, hide, multisine

pytestmark = pytest.mark.slow

EVEN = np.full(6, 1.2)
UNEVEN = np.array([1.17, 1.22, 1.2, 1.25, 1.19, 1.21])  # no two amplifiers err alike
THREE = np.array([1.2, 1.2, 1.2, 1.0, 1.0, 1.0])
APART = np.array([1.15, 1.02, 1.1, 0.94, 1.02, 1.0])  # as gains that have nothing in common
WARM = 0.86
DAYS = np.array([1.05, 1.09, 0.97, 1.04, 1.06, 1.0])  # friction of each joint on another day
DURATION = 12.0  # s: scales of 1.2 and more are large beside the noise of so many rows


def payload(mass: float) -> Arm:
    return hide(Arm(), "payload", (), mass)


def warm() -> Arm:
    cold = Arm().friction
    return replace(Arm(), friction=replace(cold, coulomb=WARM * cold.coulomb, viscous=WARM * cold.viscous))


def another_day() -> Arm:
    friction = Arm().friction
    return replace(Arm(), friction=replace(friction, coulomb=DAYS * friction.coulomb, viscous=DAYS * friction.viscous))


ARMS = {
    "plain": Arm(),
    "1 kg": payload(1.0),
    "2 kg": payload(2.0),
    "warm": warm(),
    "coupled": hide(Arm(), "coupled_friction", (5, 6), 1.0),
    "of another day": another_day(),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("scaled")


def recorded(folder: Path, arm: str, seed: int, noise: int, scale: np.ndarray | float = 1.0) -> pid.Recording:
    """The recording of an arm, its measured torques scaled; dry friction turns as tests/plant has it, not as the estimator does."""
    recording = made_once(folder / f"{arm}_{seed}_{noise}.csv", ARMS[arm], multisine(seed, duration=DURATION), noise)
    return replace(recording, effort=recording.effort * scale)


@pytest.fixture(scope="module")
def model(ur5: pid.Robot, folder: Path) -> pid.Estimate:
    return pid.identify(ur5, [recorded(folder, "plain", seed, seed) for seed in (41, 42, 43)])


def diagnosed(
    model: pid.Estimate, folder: Path, arm: str, scale: np.ndarray | float = 1.0, seeds: tuple[int, ...] = (51, 52)
) -> pid.Diagnosis:
    return pid.diagnose_motion(model, [recorded(folder, arm, seed, seed + 100, scale) for seed in seeds])


@pytest.mark.parametrize("seeds", [(51, 52), (41, 42)], ids=["other motions", "the same motions"])
@pytest.mark.parametrize("scale", [EVEN, UNEVEN], ids=["even", "uneven"])
def test_one_scale_is_named_with_the_share_of_each_joint(model, folder, scale, seeds) -> None:
    found = diagnosed(model, folder, "plain", scale, seeds)
    (cause,) = found.causes
    assert (cause.effect, cause.joints) == ("torque_scale", ())
    assert [v.joint for v in cause.parameters] == [1, 2, 3, 4, 5, 6]
    np.testing.assert_allclose([v.change for v in cause.parameters], 100 * (scale - 1), atol=0.6)
    assert "higher than the model's, as with drive gains" in cause.in_words


def test_joints_that_are_scaled_alone_are_no_scale_of_all(model: pid.Estimate, folder: Path) -> None:
    found = diagnosed(model, folder, "plain", THREE)
    assert [(f.effect, f.joints) for f in found.causes] == [("torque_constant", (1, 2, 3))]


def test_gains_that_have_nothing_in_common_are_no_scale_of_all(model: pid.Estimate, folder: Path) -> None:
    """Nearly all torque of a wrist that does not carry much is friction: a gain there is more friction as well, and both are told."""
    found = diagnosed(model, folder, "plain", APART)
    assert all("torque_constant" in {f.effect, *(one.effect for one in f.rivals)} for f in found.causes)
    assert {1, 3, 4} <= {joint for f in found.causes if f.effect == "torque_constant" for joint in f.joints}


def test_a_load_and_a_warmer_arm_are_found_beside_it(model: pid.Estimate, folder: Path) -> None:
    loaded = diagnosed(model, folder, "1 kg", EVEN)
    assert {f.effect for f in loaded.causes} == {"torque_scale", "payload"}
    mass = next(f for f in loaded.causes if f.effect == "payload").parameters[0]
    assert mass.value == pytest.approx(1.0, abs=0.05)
    assert {f.effect for f in diagnosed(model, folder, "warm", EVEN).causes} == {"torque_scale", "friction_level"}


def test_a_load_is_no_scale(model: pid.Estimate, folder: Path) -> None:
    found = diagnosed(model, folder, "2 kg")
    assert [f.effect for f in found.causes] == ["payload"]


def test_it_scales_what_the_drives_give(ur5: pid.Robot, model: pid.Estimate) -> None:
    rng = np.random.default_rng(3)
    states = pid.Signals.of_states(*rng.normal(size=(3, 50, 6)))
    shares = np.array([0.1, *rng.normal(size=6)])
    scaled = replace(
        model.model,
        effects=(*model.model.effects, TorqueScale(uneven_percent=1.0)),
        theta=np.append(model.model.theta, shares),
    )
    offset = [t for c, t in zip(model.model.columns, model.model.theta, strict=True) if c.effect == "torque_offset"]
    drives = model.model.torque(states) - np.array(offset)  # an amplifier's zero is not scaled with its gain
    expected = model.model.torque(states) + drives * (shares[0] + shares[1:] / 100)
    np.testing.assert_allclose(scaled.torque(states), expected, rtol=1e-12)
    check_effect(TorqueScale(uneven_percent=2.0), ur5)


def test_it_is_free_beside_free_masses(ur5: pid.Robot, folder: Path) -> None:
    one = recorded(folder, "plain", 41, 41)
    with pytest.raises(pid.InputError, match="torque_scale beside rigid_body leaves the scale of all torques free"):
        pid.identify(ur5, one, effects=["rigid_body", "torque_scale"])


def test_a_fit_that_frees_the_masses_has_no_scale_to_change(ur5: pid.Robot, folder: Path) -> None:
    """Of a model whose own recordings are diagnosed, a scale shows what was found, scaled, and nothing else: it is no rival of it."""
    recordings = [recorded(folder, "coupled", seed, seed) for seed in (41, 42)]
    found = pid.diagnose_motion(pid.identify(ur5, recordings), recordings)
    (cause,) = found.causes
    assert (cause.effect, cause.joints, cause.rivals) == ("coupled_friction", (5, 6), ())
    assert ("torque_scale", "inside what the baseline may take up") in {(u.effect, u.reason) for u in found.unseen}


def test_friction_that_differs_on_each_joint_is_no_scale_of_all_torque(
    model: pid.Estimate, ur5: pid.Robot, folder: Path
) -> None:
    """Beside the scale of friction by itself, each joint by a share of its own, a scale of all torque must still predict better."""
    answers = []
    for arm, scale in (("of another day", 1.0), ("plain", 1.05)):
        now = [recorded(folder, arm, seed, seed + 100, scale) for seed in (41, 42)]
        signals = prepare_all(ur5, now, model.filter)
        problem = state_problem("different", model, signals, model.filter, 0)
        (whole,) = (c for c in problem.candidates if c.name == "torque_scale")
        answers.append(scales_as_a_whole(settled_hypothesis(problem, ()), whole))
    assert answers == [False, True]
