"""Forward dynamics of many arms at once: implicit in every friction, so that a joint may stick."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.replay.arm import Arm
from physident.simulation.plant import Instants

Array = NDArray[np.float64]
STEP = 1e-3  # s
ROUNDS = 12  # of the velocity at the end of a step, which its friction depends on
CLOSE = 1e-7  # rad/s: a velocity that changes by less is found
Drive = Callable[[float, Array, Array], Array]  # time [s], q and v (N, n) to the drives' torque (N, n) [N m|N]


@dataclass(frozen=True, eq=False)
class Trace:
    """Simulated positions ``q`` [rad|m], velocities ``v`` [rad/s|m/s] and drive torques ``torque`` [N m|N], (N, T, n)."""

    q: Array
    v: Array
    torque: Array


def simulate_batch(arm: Arm, clock: Array, start: Array, state: Array, q: Array, v: Array, drive: Drive) -> Trace:
    """N arms from true states q, v (N, n) at times ``start`` (N,) [s], driven for the duration of ``clock`` (T,) [s].

    ``state`` (S, N) are the effects' internal states at the start. An arm whose speed is no longer finite stays NaN.
    """
    substeps = max(1, int(np.ceil((clock[1] - clock[0]) / STEP - 1e-9)))
    h = float(clock[1] - clock[0]) / substeps
    a = np.zeros_like(q)
    kept: list[Array] = [np.empty((len(q), len(clock), q.shape[1])) for _ in range(3)]
    with np.errstate(over="ignore", invalid="ignore"):
        for k, time in enumerate(clock):
            for part, values in zip(kept, (q, v, drive(float(time), q, v)), strict=True):
                part[:, k] = values
            for sub in range(substeps if k + 1 < len(clock) else 0):
                now = float(time) + sub * h
                q, v, a, state = _step(arm, start + now, q, v, a, state, drive(now, q, v), h)
    return Trace(*kept)


def _step(
    arm: Arm, time: Array, q: Array, v: Array, a: Array, state: Array, torque: Array, h: float
) -> tuple[Array, Array, Array, Array]:
    """One step: (M / h + K) v' = M v / h + torque - bias - F(v') + K v', K the slope of each joint's own friction."""
    M, bias = arm.dynamics(q, v)
    if not arm.plant.effects:
        a = np.asarray(np.linalg.solve(M, (torque - bias)[..., None])[..., 0], dtype=np.float64)
        after = v + h * a
        return q + h * after, after, a, state
    n = q.shape[1]
    diagonal = np.arange(n)
    at = Instants(time, q, v, a, np.einsum("kij,kj->ki", M, a) + bias, state)
    rest = _friction(arm, at, np.zeros_like(v), h)
    after = v + h * a
    for _ in range(ROUNDS):
        F = _friction(arm, at, after, h)
        small = np.where(np.abs(after) < 1e-9, 1e-9, after)
        K = np.maximum((F - rest) / small, 0.0)
        K = np.where(np.isfinite(K), K, 0.0)
        left = M / h
        left[:, diagonal, diagonal] += K
        right = np.einsum("kij,kj->ki", M, v) / h + torque - bias - F + K * after
        found = np.linalg.solve(left, right[..., None])[..., 0]
        change = np.abs(found - after)
        after = found
        if not (change > CLOSE).any():
            break
    state = arm.advanced(replace(at, v=after), h)
    return q + h * after, after, (after - v) / h, state


def _friction(arm: Arm, at: Instants, v: Array, h: float) -> Array:
    """Torque (N, n) of all effects but inertia at the end of a step at the velocity v (N, n)."""
    moved = replace(at, v=v)
    return arm.plant.torque(replace(moved, state=arm.advanced(moved, h)))
