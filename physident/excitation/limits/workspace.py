"""The workspace: torque, tool speed, table and self-collision, as limits of a motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.errors import InputError
from physident.excitation.limits.arm_geometry import ArmGeometry
from physident.excitation.limits.capsules import collision_geometry
from physident.excitation.limits.limit import Margin, WorkspaceLimit
from physident.excitation.limits.self_collision import SelfCollision
from physident.excitation.limits.table_limit import TableLimit
from physident.excitation.limits.tool_speed_limit import ToolSpeedLimit
from physident.excitation.limits.torque_limit import TorqueLimit
from physident.excitation.motion.motion import Motion
from physident.excitation.motion.trajectory import Trajectory
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
CLEARANCE = 0.02  # m, between links, and between the links and the table
CHECKED = 1000  # instants of a period at which margins are computed


@dataclass(frozen=True, eq=False)
class Workspace:
    """The limits that a motion of an ``arm`` has to respect besides those of its joints."""

    arm: ArmGeometry
    torque: TorqueLimit
    tool_speed: ToolSpeedLimit
    table: TableLimit
    self_collision: SelfCollision

    @staticmethod
    def of(
        model: Model, table: float | None = 0.0, clearance: float = CLEARANCE, meshes: str | Path | None = None
    ) -> Workspace:
        """The workspace of a model's robot.

        ``table`` [m] is the height of a plane in the base frame, None for no table; ``clearance`` [m] is kept between
        links and to the table. ``meshes`` is the folder of the robot's mesh packages. Raises InputError for collision
        geometry that cannot be read, and for a height or a clearance that cannot be used.
        """
        if not (np.isfinite(clearance) and clearance >= 0) or not (table is None or np.isfinite(table)):
            raise InputError(
                f"clearance is {clearance} m and table is {table} m; expected finite numbers, and no negative clearance"
            )
        arm = ArmGeometry(model, collision_geometry(model.robot, meshes))
        return Workspace(
            arm,
            TorqueLimit(model),
            ToolSpeedLimit(arm),
            TableLimit(arm, table, clearance),
            SelfCollision(arm, clearance),
        )

    @property
    def limits(self) -> tuple[WorkspaceLimit, ...]:
        """All limits, in the order of the constraints."""
        return self.torque, self.tool_speed, self.table, self.self_collision

    def margins(self, motion: Motion, count: int = CHECKED) -> list[Margin]:
        """Margins to all limits on ``count`` instants of a period, or of the whole motion where it has no period."""
        states = period_states(motion, count)
        return [margin for limit in self.limits for margin in limit.margins(states)]


def period_states(motion: Motion, count: int) -> Signals:
    """States at ``count`` instants of a period, or of the whole motion where it has no period."""
    length = 1 / motion.base_frequency if isinstance(motion, Trajectory) else motion.duration
    states = motion.states(np.arange(count) / count * length)
    return replace(states, rate=count / length)
