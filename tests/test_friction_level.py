"""An arm that is warmer than it was is told as one thing: the friction of all its joints at another level."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.statistics.common_share import share_of_most
from physident.effects.scales.friction_level import FrictionLevel
from physident.effects.scales.shared_scale import UNEVEN
from physident.testing import check_effect
from tests.plant import Arm, Sensors, hide, multisine, record

pytestmark = pytest.mark.slow

FALL = np.array([0.11, 0.16, 0.14, 0.12, 0.15, 0.13])  # of each joint's friction: no two joints warm alike
RUBBED = 3
QUIET = Sensors()
LOUD = Sensors(torque_noise=(1.5, 1.8, 1.2, 0.4, 0.3, 0.25), noise_memory=0.03)


def motion_again(arm: Arm, path: Path, seed: int, noise: int, sensors: Sensors = QUIET) -> pid.Recording:
    """The recording of an arm's motion; dry friction turns as tests/plant has it, not as the estimator does."""
    record(arm, multisine(seed), sensors, noise, step=4e-3).write_csv(path)
    return pid.load_recording(path)


@pytest.fixture(scope="module")
def before(tmp_path_factory: pytest.TempPathFactory) -> list[pid.Recording]:
    folder = tmp_path_factory.mktemp("before")
    return [motion_again(Arm(), folder / f"{seed}.csv", seed, seed) for seed in (41, 42, 43)]


@pytest.fixture(scope="module")
def model(ur5: pid.Robot, before: list[pid.Recording]) -> pid.Estimate:
    return pid.identify(ur5, before)


def again(arm: Arm, folder: Path) -> list[pid.Recording]:
    return [motion_again(arm, folder / f"{seed}.csv", seed, seed + 100) for seed in (41, 42)]


def test_a_warmer_arm_is_named_by_one_number(model: pid.Estimate, tmp_path: Path) -> None:
    cold = Arm().friction
    warm = replace(cold, coulomb=cold.coulomb * (1 - FALL), viscous=cold.viscous * (1 - FALL))
    found = pid.diagnose_motion(model, again(replace(Arm(), friction=warm), tmp_path))
    assert [(f.effect, f.joints) for f in found.causes] == [("friction_level", ())]
    shares = found.causes[0].parameters
    assert [v.joint for v in shares] == [1, 2, 3, 4, 5, 6]
    np.testing.assert_allclose([v.change for v in shares], -100 * FALL, atol=1.0)
    assert "11 to 16 % lower than the model's, as in a warmer arm" in found.causes[0].in_words
    assert found.estimate is not None
    found.estimate.save(tmp_path / "extended.json")
    kept = pid.load_estimate(tmp_path / "extended.json").model
    assert kept.effects == found.estimate.model.effects


def test_one_part_of_the_friction_may_have_changed_alone(model: pid.Estimate, tmp_path: Path) -> None:
    """Coulomb friction that is larger on all joints brings no viscous friction with it."""
    cold = Arm().friction
    found = pid.diagnose_motion(
        model, again(replace(Arm(), friction=replace(cold, coulomb=1.3 * cold.coulomb)), tmp_path)
    )
    (cause,) = found.causes
    assert (cause.effect, cause.joints) == ("friction_level", ())
    np.testing.assert_allclose([v.change for v in cause.parameters], 30.0, atol=2.5)
    assert cause.in_words.startswith("The Coulomb friction of all joints is")


def test_a_fault_of_one_joint_is_found_beside_the_warmth(model: pid.Estimate, tmp_path: Path) -> None:
    """What the joints of a warm arm differ by takes up no fault of one of them."""
    cold = Arm().friction
    warm = replace(cold, coulomb=cold.coulomb * (1 - FALL), viscous=cold.viscous * (1 - FALL))
    arm = hide(replace(Arm(), friction=warm), "coulomb_friction", RUBBED, 4.0)
    found = pid.diagnose_motion(model, again(arm, tmp_path))
    named = {(f.effect, f.joints) for f in found.causes}
    assert named == {("friction_level", ()), ("coulomb_friction", (RUBBED,))}


def test_a_fault_that_noise_hides_in_a_joint_s_share_does_not_undo_the_warmth(ur5: pid.Robot, tmp_path: Path) -> None:
    """A joint whose friction rose, while that of all others fell, has another share than they; noise does not show at first why."""
    model = pid.identify(
        ur5, [motion_again(Arm(), tmp_path / f"{seed}.csv", seed, seed, LOUD) for seed in (41, 42, 43)]
    )
    cold, less = Arm().friction, 1 - FALL / 3
    warm = replace(Arm(), friction=replace(cold, coulomb=cold.coulomb * less, viscous=cold.viscous * less))
    arm = hide(warm, "coulomb_friction", RUBBED, 0.8)
    found = pid.diagnose_motion(
        model, [motion_again(arm, tmp_path / f"again_{seed}.csv", seed, seed + 100, LOUD) for seed in (41, 42)]
    )
    causes = {(f.effect, f.joints): f for f in found.causes}
    assert set(causes) == {("friction_level", ()), ("coulomb_friction", (RUBBED,))}
    (dry,) = causes["coulomb_friction", (RUBBED,)].parameters
    assert dry.change == pytest.approx(0.8, abs=0.15)
    shares = causes["friction_level", ()].parameters
    np.testing.assert_allclose([v.change for v in shares], -100 * FALL / 3, atol=2.0)


def test_most_joints_say_what_all_have_in_common() -> None:
    fall, exact = np.array([-3.7, -5.3, 9.0, -4.0, -5.0, -4.3]), 0.01 * np.eye(6)
    share = share_of_most(fall, exact, UNEVEN, 3.0)
    assert share is not None
    assert share.others == (RUBBED,)
    assert share.percent == pytest.approx(-4.46, abs=0.05)
    apart = [15.0, 2.0, 10.0, -6.0, 2.0, 0.0]  # no four of which are alike
    little = [0.1, -0.1, 0.1, 9.0, -0.1, 0.05]  # what most have may be nothing
    for shares in (apart, little):
        assert share_of_most(np.array(shares), exact, UNEVEN, 3.0) is None


def test_the_friction_of_one_joint_is_not_taken_for_it(model: pid.Estimate, tmp_path: Path) -> None:
    found = pid.diagnose_motion(model, again(hide(Arm(), "coulomb_friction", RUBBED, 2.5), tmp_path))
    first = found.causes[0]
    assert (first.effect, first.joints) == ("coulomb_friction", (RUBBED,))
    assert "friction_level" not in {name for f in found.causes for name in (f.effect, *(r.effect for r in f.rivals))}


def test_it_is_the_share_by_which_a_model_s_friction_grows(model: pid.Estimate, before: list[pid.Recording]) -> None:
    """The torque of the model with all its friction half as large again, less that of the model, is half a level."""
    given = model.model
    friction = np.isin([c.effect for c in given.columns], ["coulomb_friction", "viscous_friction"])
    larger = replace(given, theta=np.where(friction, 1.5, 1.0) * given.theta)
    level, dry, wet = FrictionLevel.options_beside(given.robot, given.effect_parameters())
    assert (dry.coulomb, wet.viscous) == (level.coulomb, level.viscous)
    assert not any((*dry.viscous, *wet.coulomb))
    leveled = replace(given, effects=(*given.effects, level), theta=np.append(given.theta, 0.5))
    assert before[0].dq is not None
    states = pid.Signals.of_states(before[0].q, before[0].dq, np.zeros_like(before[0].q))
    np.testing.assert_allclose(leveled.torque(states), larger.torque(states), atol=1e-9)
    for one, two in zip(_terms(leveled), _terms(larger), strict=True):
        assert one == pytest.approx(two)


def test_what_joints_have_of_their_own_is_part_of_every_form(ur5: pid.Robot) -> None:
    uneven = FrictionLevel(coulomb=(2.0,), viscous=(3.0,), uneven_percent=2.0, smoothing=(0.01,), presliding=0.0)
    check_effect(uneven, ur5)
    held = replace(uneven, held=(RUBBED,))
    check_effect(held, ur5)
    np.testing.assert_allclose(held.told(ur5)[1] @ [-0.1, 1, 2, 4, 5, 6], [-9, -8, -10, -6, -5, -4])
    columns, told = uneven.told(ur5)
    theta = np.array([-0.1, *np.arange(6.0)])
    assert [c.unit for c in columns] == ["%"] * 6
    np.testing.assert_allclose(told @ theta, -10.0 + np.arange(6.0))
    assert [term.damping for term in uneven.joint_terms(ur5, theta) or ()] == pytest.approx(
        3 * (-0.1 + np.arange(6) / 100)
    )


def _terms(model: pid.Model) -> list[tuple[float, float]]:
    """Damping and dry friction of each joint, as a simulator adds them up."""
    total = np.zeros((model.robot.n, 2))
    for effect, theta in model.effect_parameters():
        for term in effect.joint_terms(model.robot, theta) or ():
            total[list(term.joints)] += (term.damping or 0.0, term.dry or 0.0)
    return [(float(w), float(d)) for w, d in total]


def test_a_model_without_friction_has_no_level(ur5: pid.Robot) -> None:
    plain = pid.Model.nominal(ur5, pid.make_effects(["rigid_body", "viscous_friction"]))
    assert FrictionLevel.options_beside(ur5, plain.effect_parameters()) == []


def test_no_joint_has_less_than_no_friction(ur5: pid.Robot) -> None:
    (cone,) = FrictionLevel().cones(ur5)
    assert np.all(cone.map @ [-1.0] + cone.offset == 0)


def test_sizes_for_another_robot_are_refused(ur5: pid.Robot, before: list[pid.Recording]) -> None:
    with pytest.raises(pid.InputError, match="expected 6 values that are not negative"):
        pid.identify(ur5, before[:1], effects=[*pid.make_effects(["rigid_body"]), FrictionLevel(coulomb=(1.0, 2.0))])
    with pytest.raises(pid.InputError, match=r"held is \(7,\), expected joints from 1 to 6"):
        FrictionLevel(held=(7,)).columns(ur5)
