"""A learned curve over the velocity of a joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import ClassVar

import numpy as np

from physident.effects.classification import Variable
from physident.effects.effect import Array, array_source
from physident.effects.learned.curve import LearnedCurve
from physident.effects.learned.spline import bumps, modes
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

FINE = 20.0  # times as finely is a curve over velocity resolved at standstill as at its ends
SLOW = 0.25  # of its range: below, friction breaks away
STRAIGHT = 200  # speeds at which a curve is held against a straight line


@cache
def straight_slopes(pieces: int) -> Array:
    """The slope (modes,) of the straight line nearest to each mode, both ways alike, but for the slowest quarter of its range; a unit is half the range."""
    speed = np.linspace(SLOW, 1.0, STRAIGHT)
    forward, back = (modes(pieces, False)[:, 1:].T @ bumps(pieces * _place(v), pieces) for v in (speed, -speed))
    return np.polyfit(speed, (forward - back).T / 2, 1)[0]


def _place(speed: Array) -> Array:
    """The place of a speed, by half the range, on a scale from 0 to 1."""
    return np.arcsinh(FINE * np.clip(speed, -1.0, 1.0)) / (2 * np.arcsinh(FINE)) + 0.5


@dataclass(frozen=True)
class LearnedVelocity(LearnedCurve):
    """tau_j = f_j(v_j): a friction curve beside the laws of the catalogue, finer near standstill; f in N m.

    A jump at standstill belongs to Coulomb friction. Beyond its range it goes on by the slope of the straight line nearest to all but its
    slowest quarter, which levels off over another half of the range: near its ends, how it shares a line with viscous friction changes no torque,
    and far beyond nobody knows. The friction of the joint as a sum over all effects must not drive it.
    """

    name: ClassVar[str] = "learned_velocity"
    label: ClassVar[str] = "a torque that depends on velocity"
    variable: ClassVar[Variable | None] = "velocity"
    signature: ClassVar[str] = "a curve over velocity that no law of the catalogue has"
    mistaken_for: ClassVar[str] = "stribeck_friction or nonlinear_viscous_friction: move at five speeds or more"
    is_held: ClassVar[bool] = (
        False  # few rows are fast: what all of them leave says little of friction at the highest speeds
    )
    quantity_unit: ClassVar[str] = "rad/s"
    dependence: ClassVar[str] = "velocity"

    @property
    def has_mean(self) -> bool:
        return False  # friction must not push a joint one way

    def quantity(self, signals: Signals) -> Array | None:
        return signals.v

    def quantity_source(self, robot: Robot) -> str:
        return "v"

    def _range(self, robot: Robot, joint: int, signals: Sequence[Signals]) -> tuple[float, float]:
        """The same in both directions, so that standstill is its middle."""
        low, high = super()._range(robot, joint, signals)
        fastest = max(abs(low), abs(high))
        return -fastest, fastest

    def scale(self, x: Array, low: Array, high: Array) -> Array:
        top = (high - low) / 2
        return _place((x - (low + top)) / top)

    def scale_source(self, x: str, low: Array, high: Array) -> str:
        top = (high - low) / 2
        centred = f"({x} - {array_source(low + top)})"
        inside = f"np.minimum(np.maximum({centred}, {array_source(-top)}), {array_source(top)})"
        return f"(np.arcsinh({inside} * {array_source(FINE / top)}) * {1 / (2 * np.arcsinh(FINE))} + 0.5)"

    def _free_shapes(self, robot: Robot, x: Array) -> Array:
        low, high = (self.shape_values(robot, end)[:, None] for end in ("low", "high"))
        beyond = np.tanh((x - np.clip(x, low, high)) / ((high - low) / 2))
        return super()._free_shapes(robot, x) + straight_slopes(self.pieces)[:, None] * beyond[:, None]

    def numpy_source(self, robot: Robot, theta: Array) -> str | None:
        joints, slope, low, high = self.active(robot), np.zeros(robot.n), np.zeros(robot.n), np.ones(robot.n)
        low[joints], high[joints] = (self.shape_values(robot, end) for end in ("low", "high"))
        slope[joints] = theta.reshape(len(joints), -1) @ straight_slopes(self.pieces)
        inside = f"np.minimum(np.maximum(v, {array_source(low)}), {array_source(high)})"
        beyond = f"np.tanh((v - {inside}) / {array_source((high - low) / 2)})"
        return f"({super().numpy_source(robot, theta)} + {array_source(slope)} * {beyond})"

    def friction(self, robot: Robot, speeds: Array) -> Array:
        shapes = self._shapes(robot, np.tile(speeds, (len(self.active(robot)), 1)))
        return shapes.reshape(-1, len(speeds))
