"""Row weights: near reversals, velocity noise becomes torque noise through dry friction.

Near a reversal sgn v, and with it the dry friction, follows the noise of the measured velocity. Rows are weighted down by the
noise this adds; otherwise chance at reversals looks like an effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import JointRows, Regressor, build_regressor
from physident.effects.effect import Effect
from physident.recordings.signals import Filter, Signals
from physident.recordings.velocity_noise import velocity_noise
from physident.robots.robot import Robot

Array = NDArray[np.float64]
LEAST = 0.25  # of a residual's power: as much is noise at any speed, however noisy the velocity seems
SLOWEST = 1e-3  # rad/s: the spacing of speeds at which friction is evaluated near standstill


def row_weights(model: Model, signals: Sequence[Signals], filter: Filter, sigma: Array) -> Array:
    """Weights (M, n) of rows, at most one, for residuals of size ``sigma`` (n,) [N m|N] that hold noise of velocity too."""
    through = _Power(filter.cutoff, filter.rate)
    power = build_regressor(model.robot, [_VelocityNoise(model=model)], signals, through)
    added = power.predict(np.ones(model.robot.n))
    base = np.maximum(sigma**2 - added.mean(axis=0), LEAST * sigma**2)
    return np.sqrt(base / (base + np.maximum(added, 0.0)))


def weighted(regressor: Regressor, weights: Array) -> Regressor:
    """The regressor with both sides of each row multiplied by its weight (M, n)."""
    joints = tuple(
        JointRows(rows.columns, rows.values * w[:, None]) for rows, w in zip(regressor.joints, weights.T, strict=True)
    )
    return replace(regressor, joints=joints, torque=regressor.torque * weights)


@dataclass(frozen=True)
class _Power(Filter):
    """The filter for the power of white noise: its taps are squared."""

    def taps(self, rate: float) -> Array:
        return super().taps(rate) ** 2


@dataclass(frozen=True, eq=False)
class _VelocityNoise(Effect):
    """The power of torque that noise of velocity makes through a model's friction; never part of a model."""

    model: Model | None = None

    name: ClassVar[str] = "velocity_noise"
    unit: ClassVar[str] = "N^2 m^2"

    def values(self, robot: Robot, signals: Signals) -> Array:
        assert self.model is not None
        noise = velocity_noise(signals)
        return np.array([(noise[j] * _slope(self.model, j, signals.v[:, j])) ** 2 for j in range(robot.n)])


def _slope(model: Model, j: int, v: Array) -> Array:
    """How steep (N,) the friction of joint j (index) is at speeds (N,)."""
    top = max(float(np.abs(v).max()), 10 * SLOWEST)
    speeds = SLOWEST * np.sinh(np.linspace(-1, 1, 2001) * np.arcsinh(top / SLOWEST))
    total, at = np.zeros(len(speeds)), 0
    for effect in model.effects:
        columns = effect.columns(model.robot)
        indices = [k for k, column in enumerate(columns) if column.joint == j + 1]
        total += model.theta[at + np.array(indices, dtype=np.intp)] @ effect.friction(model.robot, speeds)[indices]
        at += len(columns)
    return np.interp(v, speeds, np.gradient(total, speeds))
