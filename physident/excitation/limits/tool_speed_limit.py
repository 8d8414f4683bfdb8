"""The speed limit of the tool."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.excitation.limits.arm_geometry import ArmGeometry
from physident.excitation.limits.limit import ACTIVE_SHARE, RESERVE, Margin, WorkspaceLimit
from physident.recordings.signals import Signals

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ToolSpeedLimit(WorkspaceLimit):
    """|v_tool| <= v_max [m/s] where the robot states such a limit. The constraint is on the square, which is smooth."""

    arm: ArmGeometry

    lower = 0.0
    upper = 1.0

    @property
    def count(self) -> int:
        return int(self.arm.robot.tool_speed_limit is not None)

    def constraint(self, values: Array) -> Array:
        limit, n = self.arm.robot.tool_speed_limit, self.arm.robot.n
        return values[:, n : n + self.count] / ((1 - RESERVE) * (limit or 1.0)) ** 2

    def gradient(self, values: Array, jacobian: Array) -> Array:
        return self.constraint(jacobian)  # a linear function of the squared speed

    def margins(self, states: Signals) -> list[Margin]:
        limit = self.arm.robot.tool_speed_limit
        if limit is None:
            return []
        speed = float(self.arm.tool_speed(states.q, states.v).max())
        return [
            Margin.of(
                "tool speed", "tool", "m/s",
                reached=speed, allowed=limit, margin=limit - speed, active_below=ACTIVE_SHARE * limit,
            )
        ]  # fmt: skip
