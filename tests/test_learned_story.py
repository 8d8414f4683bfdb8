"""What bends the friction of several joints is told as one thing, once one of them needs a curve."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

import physident as pid
from physident.effects.learned.one_torque import are_one_torque
from tests.followed import followed

pytestmark = pytest.mark.slow

BUMP, SWELL = (
    3.0,
    10.0,
)  # N m, N m s^2/rad^2: at half the speed of joint 3; and the faster joint 2, the more, which a power nearly is


@dataclass(frozen=True)
class Bump(pid.FormulaEffect):
    name = "bump"
    unit = "N m"
    family = pid.Family.FRICTION
    formulas = ("np.exp(-0.5 * ((np.abs(v) - 0.4) / 0.12) ** 2) * np.tanh(v / 0.1)",)


@dataclass(frozen=True)
class Swell(pid.FormulaEffect):
    name = "swell"
    unit = "N m"
    family = pid.Family.FRICTION
    formulas = ("v * np.abs(v) / (1 + np.abs(v))",)


@dataclass(frozen=True)
class Square(Swell):
    """A law of the catalogue."""

    name = "square"
    formulas = ("v * np.abs(v)",)


def recorded(
    ur5: pid.Robot, bump: float, swell: float, noise: int = 0, duration: float = 30.0, bend: type[Swell] = Swell
) -> list[pid.Recording]:
    """Three recordings of an arm whose friction of joint 3 has a bump, and that of joint 2 a bend."""
    nominal = pid.Model.nominal(ur5)
    friction = {"viscous_friction": 5.0, "coulomb_friction": 4.0}
    theta = [friction.get(c.effect, value) for c, value in zip(nominal.columns, nominal.theta, strict=True)]
    effects = (*nominal.effects, Bump(joints=(3,)), bend(joints=(2,)))
    arm = pid.Model(ur5, effects, np.array([*theta, bump, swell]))
    sensors = pid.Sensors(encoder_step=5e-5, velocity_noise=1e-3, torque_noise=0.3)
    motions = [pid.random_trajectory(ur5, seed=seed, duration=duration, base_frequency=0.1) for seed in (1, 2, 3)]
    return [followed(arm, motion, sensors, seed=noise + k) for k, motion in enumerate(motions)]


@pytest.mark.parametrize(
    ("bend", "bump", "curves"), [(Swell, 0.0, ()), (Swell, BUMP, (2, 3)), (Square, BUMP, (3,))]
)  # a law that fits by chance gives way to a curve, the right one does not
def test_a_law_stays_where_no_joint_needs_a_curve_or_it_is_right(
    ur5: pid.Robot, bend: type[Swell], bump: float, curves: tuple[int, ...]
) -> None:
    runs = recorded(ur5, bump, SWELL, bend=bend)
    found = pid.diagnose_motion(pid.identify(ur5, runs[:2]), runs[:2], runs[2:])
    told = {cause.effect: cause.joints for cause in found.causes}
    assert told.get("learned_velocity", ()) == curves
    assert sorted({joint for joints in told.values() for joint in joints}) == ([2, 3] if bump else [2])
    assert found.after.relative[1] < 0.7 * found.before.relative[1]
    for cause in found.causes:
        for curve in cause.curves:  # a straight line is viscous friction, whichever of the two the fit gave it to
            line = np.polyfit(curve.x, curve.torque, 1)[0] * np.array(curve.x)
            assert np.ptp(line) < np.ptp(np.array(curve.torque) - line)


def with_tight_spot(run: pid.Recording, joint: int, place: float) -> pid.Recording:
    """A recording of an arm whose joint (from 1) drags about a place, with the root of one over the square of its speed as turn."""
    assert run.dq is not None
    q, v = run.q[:, joint - 1], run.dq[:, joint - 1]
    drag = 6.0 / (1 + ((q - place) / 0.3) ** 4) * v / np.sqrt(v * v + 0.08**2)  # N m
    effort = run.effort.copy()
    effort[:, joint - 1] += drag
    return replace(run, effort=effort)


def test_two_curves_of_one_joint_are_one_cause(ur5: pid.Robot) -> None:
    """A tight spot needs a curve over position, a hump of the same joint's friction one over velocity: there is one gear to look at."""
    joint = 3
    runs = [with_tight_spot(run, joint, 0.2) for run in recorded(ur5, BUMP, 0.0, duration=20.0)]
    found = pid.diagnose_motion(pid.identify(ur5, runs[:2]), runs[:2], runs[2:])
    assert [(cause.effect, cause.joints) for cause in found.causes] == [("learned_position_friction", (joint,))]
    lesser = [f for f in found.findings if f.effect == "learned_velocity" and f.joints == (joint,)]
    assert [f.grade for f in lesser] == ["contribution"]
    assert "what learned_position_friction (joint 3) leaves of one torque" in " ".join(str(found).split())


def test_a_push_one_way_is_one_curve_that_does_not_swing_where_nothing_was_recorded(ur5: pid.Robot) -> None:
    """A gas spring's torque has a mean, which is no offset beside the curve; and the joint never was in a third of its range."""
    joint, top, before = 4, 1.5, recorded(ur5, 0.0, 0.0)
    pushed = []
    for run in recorded(ur5, 0.0, 0.0, noise=10):
        effort = run.effort.copy()
        effort[:, joint - 1] += top / (1 + np.exp(-4 * (run.q[:, joint - 1] + 0.3))) ** 2  # N m
        pushed.append(replace(run, effort=effort))
    q = np.sort(np.concatenate([run.q[:, joint - 1] for run in pushed]))
    assert np.diff(q).max() > (q[-1] - q[0]) / 3
    found = pid.diagnose_motion(pid.identify(ur5, before), pushed, before=before)
    assert [(f.effect, f.joints, f.grade) for f in found.findings] == [("learned_position", (joint,), "cause")]
    (curve,) = found.findings[0].curves
    assert min(curve.torque) > -0.1 * top
    assert max(curve.torque) < 1.1 * top
    (largest,) = found.findings[0].parameters
    assert largest.interval95[0] < top < largest.interval95[1]


def test_a_curve_whose_level_gravity_may_take_is_a_cause_all_the_same(ur5: pid.Robot) -> None:
    """Two waves of cogging take nearly all of a wrist's error; that their level is open, beside an offset and gravity, makes them no less."""
    joint, runs = 4, []
    for run in recorded(ur5, 0.0, 0.0, duration=20.0):
        effort, q = run.effort.copy(), run.q[:, joint - 1]
        effort[:, joint - 1] += 1.5 * (np.sin(4 * q) + 0.7 * np.sin(6.9 * q + 1))
        runs.append(replace(run, effort=effort))
    found = pid.diagnose_motion(pid.identify(ur5, runs), runs)
    assert [(cause.effect, cause.joints) for cause in found.causes] == [("learned_position", (joint,))]
    assert "from its mean there" in found.causes[0].in_words
    (largest,) = found.causes[0].parameters
    assert largest.name == "largest_from_mean"
    assert largest.std < 0.1 * abs(largest.value)  # of its shape
    assert found.verdict == "explained"


@pytest.mark.parametrize(
    ("law", "curve", "one"),
    [
        ("coulomb_friction", "learned_velocity", True),
        ("presliding_hysteresis", "learned_velocity", True),  # once the bristles slide
        ("presliding_hysteresis", "learned_position", False),
        ("load_dependent_friction", "learned_velocity", False),
        ("coupled_friction", "learned_velocity", False),
        ("friction_level", "learned_velocity", False),
        ("torque_constant", "learned_torque", True),
        ("torque_constant", "learned_load", False),
        ("joint_spring", "learned_position", True),
        ("joint_spring", "torque_offset", True),  # where it is relaxed
        ("joint_spring", "viscous_friction", False),
        ("torque_ripple", "torque_offset", False),
    ],
)
def test_a_law_and_a_curve_of_one_quantity_are_one_torque(law: str, curve: str, one: bool) -> None:
    assert are_one_torque(law, curve) is are_one_torque(curve, law) is one
