"""The uncertainty of shape parameters, and what it adds to the covariance of the linear parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import JointRows, Regressor, build_regressor, with_transition
from physident.effects.effect import Column, Effect
from physident.identifiability.base_parameters import BaseParameters
from physident.json_records import NotNegative, Positive
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
STEP = 0.02  # relative step of the central difference: a shape parameter is known to within percents


@dataclass(frozen=True)
class FoundShape:
    """An identified shape parameter: its effect, joint (from 1), field, value and standard error in ``unit``."""

    effect: str
    joint: Positive
    field: str
    value: NotNegative
    std: NotNegative
    unit: str


@dataclass(frozen=True, eq=False)
class ShapeSensitivities:
    """Derivatives ``torque`` (k, M, n) [N m|N] of the prediction by the logarithm of each identified shape parameter.

    ``places``: index of its effect (from 0) and joint (from 1).
    """

    torque: Array
    places: tuple[tuple[int, int], ...]

    def added_to(self, regressor: Regressor, base: BaseParameters) -> tuple[Regressor, BaseParameters]:
        """The regressor and its base parameters with one more independent column for each shape parameter."""
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
        extended = replace(
            base, columns=columns, independent=independent, beta=beta, shares=np.append(base.shares, np.ones(k))
        )
        return replace(regressor, columns=columns, joints=joints), extended

    def found(self, robot: Robot, effects: Sequence[Effect], covariance: Array) -> tuple[FoundShape, ...]:
        """The shape parameters with standard errors from the covariance (r + k, r + k) of the extended problem."""
        std = np.sqrt(np.diag(covariance))[len(covariance) - len(self.places) :]
        result = []
        for (index, joint), error in zip(self.places, std, strict=True):
            effect = effects[index]
            for shape in effect.shape_parameters:
                unit = robot.joints[joint - 1].unit(shape.unit)
                value = float(effect.shape_values(robot, shape.field)[effect.active(robot).index(joint - 1)])
                result.append(FoundShape(effect.name, joint, shape.field, value, value * float(error), unit))
        return tuple(result)


def shape_sensitivities(
    robot: Robot,
    initial: Sequence[Effect],
    settled: Sequence[Effect],
    theta: Array,
    signals: Sequence[Signals],
    filter: Filter,
) -> ShapeSensitivities:
    """Sensitivities at ``theta`` (p,) to the shape parameters that ``initial`` left open; discrete ones have none."""
    signals = [with_transition(robot, settled, one) for one in signals]  # an effect alone states no width
    torque, places = [], []
    at = 0
    for index, (before, effect) in enumerate(zip(initial, settled, strict=True)):
        k = len(effect.columns(robot))
        effect_theta, at = theta[at : at + k], at + k
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
                    sides.append(build_regressor(robot, [one], signals, filter).predict(effect_theta))
                torque.append((sides[0] - sides[1]) / (2 * STEP))
                places.append((index, joint + 1))
    rows = np.array(torque) if torque else np.zeros((0, 0, robot.n))
    return ShapeSensitivities(rows, tuple(places))
