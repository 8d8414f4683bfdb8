"""A long recording of a simulated six-joint arm as a Parquet file, written in pieces: every row is another one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.dynamics.model import Model
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
RATE = 500.0  # Hz
CYCLE, MOTION = 20.0, 18.0  # s: each cycle is a motion and a rest
PIECE = 100_000  # rows written at once
ENCODER = 2 * np.pi / 2**19  # rad
CENTRE, RADIUS = 0.12, 0.06  # m: of a load
SPEED_NOISE, TORQUE_NOISE = 1e-3, 0.4  # rad/s, N m


def true_model(load: float = 0.0) -> Model:
    """The arm: a UR10e with the inertia of its description, rotors and friction; with a ``load`` [kg], a ball at its tool."""
    model = Model.nominal(pid.load_robot("ur10e"))
    theta = np.array(model.theta)
    sizes = {"rotor_inertia": 1.5, "viscous_friction": 12.0, "coulomb_friction": 8.0, "torque_offset": 0.5}
    for k, column in enumerate(model.columns):
        if column.effect in sizes:
            theta[k] = sizes[column.effect] * (1.0 if column.joint <= 3 else 0.2)
    place = [k for k, column in enumerate(model.columns) if column.effect == "rigid_body"][-10]
    theta[place : place + 10] += load * np.array([1.0, 0.0, 0.0, CENTRE, *_ball(CENTRE)])
    return Model(model.robot, model.effects, theta)


def _ball(centre: float) -> tuple[float, ...]:
    """Ixx, Ixy, Iyy, Ixz, Iyz, Izz of a ball of 1 kg in the frame of the last link, ``centre`` [m] in front of it."""
    own = 0.4 * RADIUS**2
    return own + centre**2, 0.0, own + centre**2, 0.0, 0.0, own


def write_recording(path: Path, rows: int, seed: int = 0, load: float = 0.0) -> None:
    """Write ``rows`` rows of time, q, dq and tau, with a ``load`` [kg]."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    model, rng = true_model(load), np.random.default_rng(seed)
    n = model.robot.n
    names = ["time", *(f"{kind}_{j}" for kind in ("q", "dq", "tau") for j in range(1, n + 1))]
    schema = pa.schema([(name, pa.float64()) for name in names])
    tones = _tones(n, np.random.default_rng(seed + 1))
    with pq.ParquetWriter(path, schema, compression="none", use_dictionary=False) as writer:
        for first in range(0, rows, PIECE):
            time = np.arange(first, min(first + PIECE, rows)) / RATE
            q, v, a, resting, cycle = _motion(time, tones)
            torque = model.torque(Signals.of_states(q, np.where(resting[:, None], 0.0, v), a))
            torque += np.where(resting[:, None], _held(model, cycle, seed), 0.0)
            torque += TORQUE_NOISE * rng.standard_normal(q.shape)
            measured = np.round(q / ENCODER) * ENCODER
            speed = v + SPEED_NOISE * rng.standard_normal(q.shape)
            columns = [time, *measured.T, *speed.T, *torque.T]
            writer.write_table(pa.table([pa.array(column) for column in columns], schema=schema))


def _tones(n: int, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Amplitude [rad], frequency [rad/s] and phase (5, n) of the motion; the frequencies have no common period."""
    frequency = 2 * np.pi * (0.05 + 0.25 * rng.random((5, n)))
    return 0.8 * rng.random((5, n)) / frequency, frequency, 2 * np.pi * rng.random((5, n))


def _motion(time: Array, tones: tuple[Array, Array, Array]) -> tuple[Array, Array, Array, NDArray[np.bool_], Array]:
    """Position, velocity and acceleration (N, n), which rows are at rest, and the cycle of each row."""
    cycle, within = np.floor(time / CYCLE), np.mod(time, CYCLE)
    share = np.minimum(within / MOTION, 1.0)
    # the phase stands still between two motions, and passes there and back smoothly
    phase = cycle * MOTION + MOTION * (share - np.sin(2 * np.pi * share) / (2 * np.pi))
    rate = 1 - np.cos(2 * np.pi * share)
    change = 2 * np.pi / MOTION * np.sin(2 * np.pi * share)
    amplitude, frequency, start = tones
    angle = frequency * phase[:, None, None] + start
    q = (amplitude * np.sin(angle)).sum(axis=1)
    first = (amplitude * frequency * np.cos(angle)).sum(axis=1)
    second = -(amplitude * frequency**2 * np.sin(angle)).sum(axis=1)
    v, a = first * rate[:, None], second * rate[:, None] ** 2 + first * change[:, None]
    return q, v, a, within >= MOTION, cycle


def _held(model: Model, cycle: Array, seed: int) -> Array:
    """Friction (N, n) that holds the joints during the rest of each cycle: anything inside its band."""
    numbers = cycle.astype(int)
    shares = {k: np.random.default_rng([seed, k]).uniform(-1, 1, model.robot.n) for k in np.unique(numbers).tolist()}
    return np.array([shares[k] for k in numbers.tolist()]) * model.parameters("coulomb_friction")
