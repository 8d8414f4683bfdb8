"""What a world is, and the first of them: all that is drawn before anything is hidden."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from studies.open_world import arms, motions, outside, sensors
from studies.open_world.outside import Hidden, Outside
from studies.open_world.scale import prismatic, scale_of
from studies.open_world.sensors import Sensors
from tests.truth import ArmTruth, Motion


class OutsideCause(Protocol):
    """A cause outside of the catalogue, as ``outside.Outside`` describes it."""

    @property
    def kind(self) -> str:
        """Its name."""
        ...

    @property
    def joints(self) -> tuple[int, ...]:
        """Joints (from 1) where it acts."""
        ...

    @property
    def variable(self) -> str:
        """What its torque depends on most."""
        ...

    @property
    def most(self) -> float:
        """The largest sensible size."""
        ...

    @property
    def make(self) -> Callable[[float], Hidden]:
        """What a plant hides for a relative size."""
        ...


class World(Protocol):
    """Arms, motions, instruments, temperatures and causes outside of the catalogue, each from a seed."""

    @property
    def OUTSIDE(self) -> tuple[str, ...]:
        """Names of the causes outside of the catalogue."""
        ...

    def arm(self, seed: int) -> ArmTruth:
        """An arm with its background."""
        ...

    def motion(self, arm: ArmTruth, seed: int, duration: float) -> Motion:
        """A motion within an arm's limits."""
        ...

    def sensors(self, seed: int) -> Sensors:
        """The instruments of the arm of a seed."""
        ...

    def conditions(self, seed: int) -> float:
        """How much warmer [K] a recording is than those that a model was identified from."""
        ...

    def outside(self, name: str, arm: ArmTruth, rng: np.random.Generator) -> OutsideCause:
        """A cause outside of the catalogue."""
        ...


class FirstWorld:
    """The world that the diagnosis was developed in."""

    OUTSIDE = tuple(outside.MAKERS)

    def arm(self, seed: int) -> ArmTruth:
        """An arm with its background."""
        return arms.arm(seed)

    def motion(self, arm: ArmTruth, seed: int, duration: float) -> Motion:
        """A motion within an arm's limits; ten seeds in a row share its kind and pace."""
        return motions.motion(arm, seed, duration)

    def sensors(self, seed: int) -> Sensors:
        """The instruments of the arm of a seed."""
        arm = arms.arm(seed)
        return sensors.draw(seed, scale_of(arm).torque, prismatic(arm.urdf))

    def conditions(self, seed: int) -> float:
        """How much warmer [K] a recording is; it matters to the third of the arms whose friction falls with temperature."""
        return float(np.random.default_rng([seed // 10, 19]).uniform(0.0, 10.0))

    def outside(self, name: str, arm: ArmTruth, rng: np.random.Generator) -> Outside:
        """A cause outside of the catalogue."""
        return outside.outside(name, arm, rng)
