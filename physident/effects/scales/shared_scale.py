"""A part of an arm's torque that is scaled by one share on all joints, and by some per cent more or less on each."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.effects.classification import Cone, Scope, every_joint_pattern
from physident.effects.effect import Array, Column, Effect
from physident.errors import InputError
from physident.robots.robot import Robot

UNEVEN = 1 / 3  # of the arm's share: what all joints have in common, each has in its own measure


@dataclass(frozen=True)
class SharedScale(Effect):
    """tau_j = (s + d_j / 100) p_j: a part p_j of the torque of joint j, which a subclass names, differs by a share s, without a
    unit, and by d_j per cent more on each joint; none falls below zero.

    ``uneven_percent`` is the standard deviation that a prior gives d_j, which is zero where it is not given, and of the joints (from 1)
    that are ``held`` at the arm's share.
    """

    uneven_percent: float | None = None
    held: tuple[int, ...] = ()

    unit: ClassVar[str] = "1, %"
    scope: ClassVar[Scope] = Scope.WHOLE_ARM
    within_model: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.uneven_percent is not None and not (np.isfinite(self.uneven_percent) and self.uneven_percent > 0):
            raise InputError(
                f"{self.name}: uneven_percent is {self.uneven_percent}, expected per cent above 0, or none"
            )

    def _uneven(self, robot: Robot) -> list[int]:
        """The joints (from 0) that have a number of their own; raises InputError where one is held that the arm does not have."""
        if not set(self.held) <= set(range(1, robot.n + 1)):
            raise InputError(f"{self.name}: held is {self.held}, expected joints from 1 to {robot.n}")
        return [j for j in range(robot.n) if self.uneven_percent and j + 1 not in self.held]

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return (
            Column(self.name, "1", 1, self.name),
            *(Column(f"{self.name}_percent_{j + 1}", "%", j + 1, self.name) for j in self._uneven(robot)),
        )

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        own = [(j, 1 + k) for k, j in enumerate(self._uneven(robot))]
        return np.concatenate([every_joint_pattern(robot.n, 1), np.array(own, dtype=np.intp).reshape(-1, 2)])

    def of_part(self, robot: Robot, part: Array) -> Array:
        """Structural non-zeros (E, N) by the part (n, N) of each joint's torque that is scaled."""
        return np.concatenate([part, part[self._uneven(robot)] / 100])

    def percent(self, robot: Robot) -> Array:
        """By how much each joint differs, in per cent, for one unit of each parameter (n, k)."""
        return np.hstack([np.full((robot.n, 1), 100.0), np.eye(robot.n)[:, self._uneven(robot)]])

    def shares(self, robot: Robot, theta: Array) -> Array:
        """By what share (n,) each joint differs."""
        return self.percent(robot) @ theta / 100

    def told(self, robot: Robot) -> tuple[tuple[Column, ...], Array]:
        """By how much each joint differs, in per cent."""
        if not self.uneven_percent:
            return (Column(self.name, "%", 1, self.name),), np.full((1, 1), 100.0)
        columns = tuple(Column(f"{self.name}_{j}", "%", j, self.name) for j in range(1, robot.n + 1))
        return columns, self.percent(robot)

    def once_sized(self, theta: Array) -> Effect:
        """With joints that differ by a third more or less than the arm: what scales one of them by far more is another effect."""
        share = 100 * UNEVEN * abs(float(theta[0]))
        return self if self.uneven_percent or share == 0.0 else replace(self, uneven_percent=share)

    def prior_sizes(self, robot: Robot) -> Array | None:
        # common to both units: a share of the arm that is as large as per cent of a joint is not held at all
        return None if self.uneven_percent is None else np.full(len(self.columns(robot)), self.uneven_percent)

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        """No joint has less than none of it."""
        rows = self.percent(robot)[: robot.n if self.uneven_percent else 1] / 100
        return (Cone(rows, np.ones(len(rows))),)


def sized(shares: Array) -> tuple[str, str]:
    """Shares of joints that differ one way, as "11 to 16 %" or "20 %", and the way: "higher" or "lower"; of joints that differ both
    ways as "2 % lower to 3 % higher", and nothing."""
    percent = 100 * shares
    first, last = (f"{size:.0f}" if size >= 10 else f"{size:.2g}" for size in map(abs, (percent.min(), percent.max())))
    if percent.min() < 0 < percent.max():
        return f"{first} % lower to {last} % higher", ""
    low, high = sorted((first, last), key=float)
    return f"{low if low == high else f'{low} to {high}'} %", "higher" if percent.max() > 0 else "lower"
