"""How sure a shape parameter is, and what its uncertainty adds to the parameters beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import JointRows, Regressor, build_regressor
from physident.effects.effect import Column, Effect
from physident.identifiability.base_parameters import BaseParameters
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
STEP = 0.02  # relative: of the central difference in a shape, which is known to percents


@dataclass(frozen=True)
class FoundShape:
    """A shape parameter that identification found: its effect, joint, field, value and standard error in ``unit``."""

    effect: str
    joint: int
    field: str
    value: float
    std: float
    unit: str


@dataclass(frozen=True, eq=False)
class Slopes:
    """Derivatives of the prediction with the logarithm of each found shape: ``torque`` (k, M, n) [N m|N], and where each
    belongs: effect's index, joint."""

    torque: Array
    places: tuple[tuple[int, int], ...]

    def added_to(self, regressor: Regressor, base: BaseParameters) -> tuple[Regressor, BaseParameters]:
        """The regressor and its base parameters with one more independent column for each shape."""
        p, k = len(regressor.columns), len(self.places)
        names = tuple(Column(f"shape_{i}", "1", joint, "shape") for i, (_, joint) in enumerate(self.places))
        joints = tuple(
            JointRows(
                np.append(rows.columns, np.arange(p, p + k)), np.column_stack([rows.values, self.torque[:, :, j].T])
            )
            for j, rows in enumerate(regressor.joints)
        )
        columns = (*regressor.columns, *names)
        independent = np.append(base.independent, np.arange(p, p + k))
        beta = np.concatenate([base.beta, np.zeros((k, base.beta.shape[1]))])
        grown = replace(
            base, columns=columns, independent=independent, beta=beta, shares=np.append(base.shares, np.ones(k))
        )
        return replace(regressor, columns=columns, joints=joints), grown

    def found(self, robot: Robot, effects: Sequence[Effect], covariance: Array) -> tuple[FoundShape, ...]:
        """The shapes with standard errors from the covariance (r + k, r + k) of the grown problem."""
        std = np.sqrt(np.diag(covariance))[len(covariance) - len(self.places) :]
        result = []
        for (index, joint), error in zip(self.places, std, strict=True):
            effect = effects[index]
            for shape in effect.shape_parameters:
                value = float(effect.shape_values(robot, shape.field)[effect.active(robot).index(joint - 1)])
                result.append(FoundShape(effect.name, joint, shape.field, value, value * float(error), shape.unit))
        return tuple(result)


def shape_slopes(
    robot: Robot,
    asked: Sequence[Effect],
    found: Sequence[Effect],
    theta: Array,
    signals: Sequence[Signals],
    filter: Filter,
) -> Slopes:
    """Slopes of the shapes that ``asked`` left open and ``found`` holds, at the parameters (p,); discrete shapes have none."""
    torque, places = [], []
    at = 0
    for index, (before, effect) in enumerate(zip(asked, found, strict=True)):
        k = len(effect.columns(robot))
        own, at = theta[at : at + k], at + k
        for shape in effect.shape_parameters:
            if shape.discrete or getattr(before, shape.field) is not None or getattr(effect, shape.field) is None:
                continue
            values = np.array(effect.shape_values(robot, shape.field))
            for place, joint in enumerate(effect.active(robot)):
                sides = []
                for factor in (1 + STEP, 1 - STEP):
                    moved = values.copy()
                    moved[place] *= factor
                    one = replace(effect, **{shape.field: tuple(moved)})
                    sides.append(build_regressor(robot, [one], signals, filter).predict(own))
                torque.append((sides[0] - sides[1]) / (2 * STEP))
                places.append((index, joint + 1))
    rows = np.array(torque) if torque else np.zeros((0, 0, robot.n))
    return Slopes(rows, tuple(places))
