"""The torque limit of each joint."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.excitation.limits.limit import ACTIVE_SHARE, RESERVE, Margin, WorkspaceLimit
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
SPEEDS = 50  # at which friction is evaluated, from standstill to the speed limit
MIN_SHARE = 1e-6  # of the torque limit: left for inertia and gravity where friction alone exceeds the limit


@dataclass(frozen=True, eq=False)
class TorqueLimit(WorkspaceLimit):
    """|tau| <= tau_max for every joint of a ``model``'s robot that states a torque limit [N m|N].

    The search sees the torque of inertia and gravity, and keeps the largest friction free for each joint. The margin is
    that of the whole model's torque.
    """

    model: Model

    lower = -1.0
    upper = 1.0

    @cached_property
    def joints(self) -> NDArray[np.intp]:
        """Joints (from 0) with a torque limit."""
        return np.flatnonzero(np.isfinite(self.model.robot.torque_limit))

    @cached_property
    def available(self) -> Array:
        """Torque [N m|N] that friction leaves to inertia and gravity on those joints."""
        limit = self.model.robot.torque_limit[self.joints]
        return np.maximum((1 - RESERVE) * limit - largest_friction(self.model)[self.joints], MIN_SHARE * limit)

    @property
    def count(self) -> int:
        return len(self.joints)

    def constraint(self, values: Array) -> Array:
        return values[:, self.joints] / self.available

    def gradient(self, values: Array, jacobian: Array) -> Array:
        return jacobian[:, self.joints] / self.available[:, None]

    def margins(self, states: Signals) -> list[Margin]:
        torque = np.abs(self.model.torque(states)).max(axis=0)
        result = []
        for j in self.joints.tolist():
            limit = float(self.model.robot.torque_limit[j])
            unit = "N" if self.model.robot.joints[j].kind == "prismatic" else "N m"
            result.append(
                Margin.of(
                    "torque", f"joint {j + 1}", unit,
                    reached=torque[j], allowed=limit, margin=limit - torque[j], active_below=ACTIVE_SHARE * limit,
                )
            )  # fmt: skip
        return result


def largest_friction(model: Model) -> Array:
    """The largest friction torque (n,) [N m|N] of a model up to each joint's speed limit."""
    robot, start, total = model.robot, 0, np.zeros(model.robot.n)
    for effect in model.effects:
        columns = effect.columns(robot)
        theta = model.theta[start : start + len(columns)]
        start += len(columns)
        if effect.name == "torque_offset" or effect.inertia(robot, theta) is not None:
            continue
        for k, column in enumerate(columns):
            limit = robot.velocity_limit[column.joint - 1]
            speeds = np.linspace(0, limit if np.isfinite(limit) else np.pi, SPEEDS)
            total[column.joint - 1] += np.abs(effect.friction(robot, speeds)[k] * theta[k]).max()
    return total
