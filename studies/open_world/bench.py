"""One arm on the bench: its truth, its plant and instruments, and what a user identified while it was healthy."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import physident as pid
from studies.open_world.sensors import Sensors
from studies.open_world.taken import Taken, take
from studies.open_world.world import FirstWorld, World
from tests.truth import ArmTruth, Disturbance, HiddenEffect, Plant

Array = NDArray[np.float64]
CACHE = Path(os.environ.get("PHYSIDENT_CACHE", Path.home() / ".cache" / "physident")) / "open_world"
DURATION = 20.0  # s
ARMS = 16  # of a set
AGAIN = "again"  # the first world, where two recordings of a trial repeat motions of the healthy arm's
HEALTHY = 900_000_000  # seeds of motions from here on belong to healthy arms
DEFAULT = ("rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction", "torque_offset")


@dataclass(frozen=True, eq=False)
class Bench:
    """An arm of a set of the world of some ``name``, with everything that its recordings share; ``folder`` is where they are kept."""

    name: str
    world: World
    group: int
    index: int
    arm: ArmTruth
    sensors: Sensors
    plant: Plant
    robot: pid.Robot
    filter: pid.Filter
    folder: Path

    def record(
        self,
        path: Path,
        seed: int,
        warmer: float,
        effects: tuple[HiddenEffect, ...] = (),
        disturbances: tuple[Disturbance, ...] = (),
        known: bool = True,
        along: int | None = None,
    ) -> Taken:
        """A recording of the motion that a seed draws, its own or the one ``along`` which the arm moves again, with causes hidden in
        the arm; from disk where it was made before."""
        motion = self.world.motion(self.arm, seed if along is None else along, DURATION)
        return take(path, self.plant, self.arm, motion, self.sensors, seed, warmer, effects, disturbances, known)

    def nominal(self) -> pid.Model:
        """The model of somebody who knows the links, rotors and sliding friction of the arm perfectly."""
        friction = self.arm.friction
        theta = (
            self.arm.links.ravel(), self.arm.rotor_inertia, friction.viscous, friction.coulomb, self.arm.torque_offset
        )  # fmt: skip
        return pid.Model(self.robot, pid.make_effects(DEFAULT), np.concatenate(theta))


@lru_cache(maxsize=32)
def bench(name: str, group: int, index: int) -> Bench:
    """The arm of an index in a set; even ones stand before the pinocchio plant, odd ones before MuJoCo's."""
    world, seed = world_of(name), 10_000 * group + index
    arm, sensors = world.arm(seed), world.sensors(seed)
    folder = CACHE / name / f"set{group}" / f"arm{index:02d}"
    folder.mkdir(parents=True, exist_ok=True)
    described = folder / "robot.urdf"
    if not described.exists():
        described.write_text(arm.urdf, encoding="utf-8")
    cutoff = 5.0 if sensors.rate < 125 else 8.0
    return Bench(
        name,
        world,
        group,
        index,
        arm,
        sensors,
        plants()[index % 2],
        pid.load_robot(described),
        pid.Filter(cutoff),
        folder,
    )


@lru_cache(maxsize=32)
def identified(name: str, group: int, index: int) -> pid.Estimate:
    """What was identified from three recordings of different days; raises PhysidentError where physident refuses them."""
    one = bench(name, group, index)
    runs = [one.record(one.folder / f"before{k}", healthy_seed(group, index, k), 0.0).recording for k in range(3)]
    return pid.identify(one.robot, runs, filter=one.filter)


def healthy_seed(group: int, index: int, k: int) -> int:
    """The seed of the motion of recording k of a healthy arm."""
    return HEALTHY + 100 * (10_000 * group + index) + 10 * k


@cache
def plants() -> tuple[Plant, Plant]:
    """Both plants."""
    from tests.plant.open_plant import PinocchioPlant
    from tests.plant_mujoco import MujocoPlant

    return PinocchioPlant(), MujocoPlant()


@cache
def world_of(name: str) -> World:
    """The first world, the same with repeated motions (again), or the second, which the diagnosis was not developed in."""
    if name in ("first", AGAIN):
        return FirstWorld()
    from studies.open_world_second.world import SecondWorld

    return SecondWorld()
