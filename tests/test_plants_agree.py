"""Two plants, one arm: alike where friction is a settled function of speed, each with its own friction where speed changes sign.

Torque is compared along one motion, so neither integrator takes part. That energy is kept and that friction gives none away
is each plant's own to show: ``test_energy_without_friction_is_the_motors_work``, ``test_friction_never_gives_more_than_it_took``
and ``test_dry_friction_takes_energy_in_every_row_that_slides`` in test_open_plant.py;
``test_the_motors_work_becomes_energy_and_heat``, ``test_bristles_never_give_more_work_than_they_store`` and
``test_dry_friction_opposes_every_motion`` in test_plant_mujoco.py.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import erf

from tests.plant.open_plant import PinocchioPlant
from tests.plant_mujoco import MujocoPlant
from tests.serial_arms import ARMS, Kind, Sway, make_arm
from tests.truth import ArmTruth, HiddenEffect, Plant, Run

Array = NDArray[np.float64]
PINOCCHIO, MUJOCO = PinocchioPlant(), MujocoPlant()
NAMES = ["two", "scara", "seven"]
KINDS: tuple[Kind, ...] = ("dry", "bristle", "smooth")
STEP = 2e-3  # s
ALIKE = 1e-6  # of the largest torque
EFFECTS = (
    HiddenEffect(effect="payload", joints=(), size=1.5, shape={"com": (0.02, -0.03, 0.1), "radius": 0.06}),
    HiddenEffect(effect="gravity_tilt", joints=(), size=0.1, shape={"direction": 1.1}),
    HiddenEffect(effect="viscous_friction", joints=(1,), size=2.0),
    HiddenEffect(effect="torque_constant", joints=(2,), size=0.07),
    HiddenEffect(effect="joint_zero_offset", joints=(1,), size=0.03),
    HiddenEffect(effect="joint_spring", joints=(2,), size=4.0),
)


def motion(name: str) -> Run:
    """One motion of an arm, with many reversals."""
    plan = Sway(np.where([joint.kind == "prismatic" for joint in ARMS[name]], 0.08, 0.5))
    time = np.arange(0.0, plan.duration, STEP)
    q, v, a = plan.states(time)
    return Run(time, q, v, a, np.zeros_like(q), np.full_like(q, 25.0), None)


def both(arm: ArmTruth, run: Run) -> tuple[Array, Array]:
    """Torque (N, n) [N m] that the arm needs, by each plant."""
    return PINOCCHIO.torque_along(arm, run), MUJOCO.torque_along(arm, run)


def apart(one: Array, other: Array) -> float:
    """Largest difference where both are known, over the largest torque of its joint."""
    return float(np.nanmax(np.abs(one - other) / np.nanmax(np.abs(one), axis=0)))


def friction_like(arm: ArmTruth, **rows: float) -> ArmTruth:
    """The arm with other friction, alike in all joints."""
    return replace(arm, friction=replace(arm.friction, **{key: np.full(arm.joints, x) for key, x in rows.items()}))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("effects", [(), EFFECTS], ids=["healthy", "changed"])
def test_without_friction_both_need_the_same_torque(name: str, effects: tuple[HiddenEffect, ...]) -> None:
    arm = make_arm(name, "smooth", coulomb=0.0, breakaway=0.0, effects=effects)
    assert apart(*both(arm, motion(name))) < ALIKE


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["dry", "smooth"])
def test_friction_that_has_turned_is_the_same_in_both(name: str, kind: Kind) -> None:
    """One law lacks (width/v)^2 / 2 of its level, the other nothing: they meet to 1e-6 a thousand widths from zero speed. The
    peak of breakaway is gone as far as that after fifteen Stribeck speeds."""
    arm = friction_like(make_arm(name, kind), width=1e-5, stribeck_speed=1e-3)
    run = motion(name)
    far = np.where(np.abs(run.v) > 0.02, 1.0, np.nan)
    assert np.isfinite(far).mean() > 0.8
    one, other = both(arm, run)
    assert apart(one * far, other * far) < ALIKE


@pytest.mark.parametrize("name", NAMES)
def test_smooth_friction_differs_by_its_two_laws_and_by_nothing_else(name: str) -> None:
    """The laws are written out here; eight widths and five Stribeck speeds from zero speed they are within 1 % of one another."""
    arm, run = make_arm(name, "smooth"), motion(name)
    f, speed = arm.friction, np.abs(run.v)
    peak = f.breakaway - f.coulomb
    first = (f.coulomb + peak * np.exp(-speed / f.stribeck_speed)) * run.v / np.hypot(run.v, f.width)
    second = (f.coulomb + peak / np.cosh(speed / f.stribeck_speed)) * erf(run.v / f.width)
    one, other = both(arm, run)
    assert apart(one - first, other - second) < ALIKE
    turned = speed > np.maximum(8 * f.width, 5 * f.stribeck_speed)
    assert np.abs(np.where(turned, one - other, 0.0)).max() < 0.01 * f.coulomb.max()


def test_near_a_reversal_each_plant_has_a_law_of_its_own() -> None:
    """Smooth friction and bristles differ between the plants; dry friction can only be one thing where a joint slides."""
    run = motion("two")
    near = np.abs(run.v) < 0.02
    least: dict[Kind, float] = {"smooth": 0.1, "bristle": 0.02}  # of the level
    for kind, share in least.items():
        arm = make_arm("two", kind)
        one, other = both(arm, run)
        assert (np.nanmax(np.abs(one - other) * near, axis=0) > share * arm.friction.coulomb).all(), kind
    one, other = both(make_arm("two", "dry", breakaway=2.0), run)
    assert apart(one, other) < ALIKE


@pytest.mark.parametrize("plant", [PINOCCHIO, MUJOCO], ids=lambda plant: plant.name)
def test_near_a_reversal_the_kinds_of_friction_differ(plant: Plant) -> None:
    """By a tenth of the level at least, in rows that move and in which dry friction is determined."""
    run = motion("two")
    near = (np.abs(run.v) < 0.02) & (np.abs(run.v) > 0)
    dry, bristle, smooth = (plant.torque_along(make_arm("two", kind), run) for kind in KINDS)
    for one, other in ((dry, bristle), (dry, smooth), (bristle, smooth)):
        known = near & np.isfinite(one) & np.isfinite(other)
        assert (np.max(np.abs(np.where(known, one - other, 0.0)), axis=0) > 0.1 * 2.0).all()
