"""A model: a robot, a tuple of effects, and a value for each of their parameters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.effects.catalogue import DEFAULT_EFFECTS, effect_from_dict, make_effects
from physident.effects.effect import Column, Effect
from physident.errors import InputError
from physident.robot import Robot
from physident.signals import Signals

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Model:
    """Torque of a robot as a sum of effects, tau = sum_e Phi_e(q, v, a) theta_e.

    ``theta`` (p,) holds the effects' parameters one after another, in the units of ``columns``.
    """

    robot: Robot
    effects: tuple[Effect, ...]
    theta: Array

    def __post_init__(self) -> None:
        theta = np.array(self.theta, dtype=float)
        if theta.shape != (len(self.columns),) or not np.isfinite(theta).all():
            raise InputError(f"theta has shape {theta.shape}, expected {len(self.columns)} finite numbers")
        theta.setflags(write=False)
        object.__setattr__(self, "theta", theta)

    @staticmethod
    def nominal(robot: Robot, effects: Iterable[str | Effect] = DEFAULT_EFFECTS) -> Model:
        """The model with every parameter as the robot's own description states it, zero where it states none."""
        made = make_effects(effects)
        return Model(robot, made, np.concatenate([effect.nominal(robot) for effect in made]))

    @property
    def columns(self) -> tuple[Column, ...]:
        """Name, unit and joint of each parameter, in the order of ``theta``."""
        return tuple(column for effect in self.effects for column in effect.columns(self.robot))

    def parameters(self, effect: str) -> Array:
        """The parameters of one effect by name; raises InputError where the model has no such effect."""
        chosen = [i for i, column in enumerate(self.columns) if column.effect == effect]
        if not chosen:
            names = ", ".join(e.name for e in self.effects)
            raise InputError(f"the model has no effect {effect!r}, expected one of {names}")
        return self.theta[chosen]

    def torque(self, signals: Signals) -> Array:
        """Joint torques (N, n) [N m|N] at every sample of the signals, unfiltered."""
        tau = np.zeros((self.robot.n, len(signals.time)))
        at = 0
        for effect in self.effects:
            pattern = effect.pattern(self.robot)
            values = effect.values(self.robot, signals)
            for (row, column), entries in zip(pattern, values, strict=True):
                tau[row] += self.theta[at + column] * entries
            at += len(effect.columns(self.robot))
        return tau.T

    def as_dict(self) -> dict[str, Any]:
        """Robot, effects and values, as JSON can hold them."""
        return {
            "robot": self.robot.as_dict(),
            "effects": [effect.as_dict() for effect in self.effects],
            "parameters": [
                {"name": c.name, "joint": c.joint, "unit": c.unit, "value": float(value)}
                for c, value in zip(self.columns, self.theta, strict=True)
            ],
        }

    @staticmethod
    def from_dict(data: dict[str, Any]) -> Model:
        """The model that ``as_dict`` described."""
        effects = tuple(effect_from_dict(effect) for effect in data["effects"])
        robot = Robot.from_dict(data["robot"])
        return Model(robot, effects, np.array([parameter["value"] for parameter in data["parameters"]]))
