"""What the open world's judge holds for true of an arm is what its plants do."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from studies.open_world.scoring import FALLS, true_of
from tests.plant.open_plant import PinocchioPlant
from tests.plant_mujoco import MujocoPlant
from tests.serial_arms import Kind, make_arm
from tests.truth import ArmTruth, Plant, Run

COULOMB, BREAKAWAY = 2.0, 3.0  # N m
CREEP, FAST = 0.02, 0.6  # rad/s: well below and above the speed over which breakaway fades
PLANTS = [PinocchioPlant(), MujocoPlant()]
KINDS: tuple[Kind, ...] = ("dry", "bristle", "smooth")


def sliding_friction(plant: Plant, arm: ArmTruth, speed: float) -> NDArray[np.float64]:
    """Friction (n,) [N m] less its viscous part of joints that slide at a steady speed [rad/s]: half of what both directions need."""
    time = np.arange(0.0, 1.0, 1e-3)
    needed = []
    for way in (1.0, -1.0):
        v = np.full((len(time), arm.joints), way * speed)
        q = v * (time - time[-1])[:, None]  # both directions end at one place
        run = Run(time, q, v, np.zeros_like(q), np.zeros_like(q), np.full_like(q, 25.0), None)
        needed.append(plant.torque_along(arm, run)[-1])
    return np.abs(needed[0] - needed[1]) / 2 - arm.friction.viscous * speed


def bench_of(arm: ArmTruth, question: str, warmer: float) -> Any:
    """A scene as the judge asks it."""
    return SimpleNamespace(
        question=question, refitted=question == "missing", warmer=lambda _: warmer, bench=SimpleNamespace(arm=arm)
    )


def arm_of(kind: Kind, **rows: float) -> ArmTruth:
    arm = make_arm("two", kind)
    friction = {"coulomb": COULOMB, "breakaway": BREAKAWAY, "stribeck_speed": 0.06, "width": 0.004, **rows}
    return replace(arm, friction=replace(arm.friction, **{key: np.full(2, x) for key, x in friction.items()}))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("plant", PLANTS, ids=["pinocchio", "mujoco"])
def test_friction_of_every_kind_dips_after_breakaway(plant: Plant, kind: Kind) -> None:
    arm = arm_of(kind)
    assert (sliding_friction(plant, arm, CREEP) > FALLS * sliding_friction(plant, arm, FAST)).all()
    names = {name for name, _ in true_of(bench_of(arm, "missing", 0.0))}
    assert {"stribeck_friction", "learned_velocity"} <= names
    flat = arm_of(kind, breakaway=COULOMB)
    np.testing.assert_allclose(sliding_friction(plant, flat, CREEP), sliding_friction(plant, flat, FAST), rtol=0.03)
    assert "stribeck_friction" not in {name for name, _ in true_of(bench_of(flat, "missing", 0.0))}


@pytest.mark.parametrize("question", ["different", "nominal", "missing"])
def test_friction_that_fell_is_a_change_to_whoever_knows_it_from_the_cold(question: str) -> None:
    arm = arm_of("smooth", per_degree=0.01)
    fell = {("friction_level", ()), ("coulomb_friction", (1,)), ("viscous_friction", (2,))}
    assert (fell <= true_of(bench_of(arm, question, 8.0))) is (question != "missing")
    assert not fell & true_of(bench_of(arm, question, 0.0))
    assert not fell & true_of(bench_of(arm_of("smooth", per_degree=0.0), question, 8.0))
