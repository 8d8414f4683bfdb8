"""Effects by what their values mean: each by itself, or a size that the torque is evaluated at."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Self

from physident.effects.effect import Array, Effect
from physident.robots.robot import Robot


@dataclass(frozen=True)
class OneByOne(Effect):
    """An effect with a sentence on its values, as a diagnosis tells them, some of which may be left out."""

    @abstractmethod
    def told_in_words(self, robot: Robot, values: Array) -> str:
        """A sentence on the ``values`` (r,) that a diagnosis tells, see ``told``; zero are those that are left out."""

    def in_words(self, robot: Robot, theta: Array) -> str:
        return self.told_in_words(robot, self.told(robot)[1] @ theta)


@dataclass(frozen=True)
class AboutItsSize(Effect):
    """An effect whose torque is no line over its parameters, and whose regressor is exact at those that it is about."""

    @abstractmethod
    def once_sized(self, theta: Array) -> Self:
        """The effect about ``theta`` (k,)."""
