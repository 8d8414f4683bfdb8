"""Forty arms of one kind over two years: every arm another one, every day another temperature, and some that degrade.

It shares no code with the package: the dynamics are pinocchio's, friction, transmission, drives and instruments are written here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Array = NDArray[np.float64]
JOINTS = 3
RATE, DURATION = 100.0, 20.0  # Hz, s
STILL = 1.0  # s at rest before and after the motion
COMFORT = 24.0  # degC, where friction is as stated
DRY, VISCOUS, LIFT = (9.0, 11.0, 5.0), (14.0, 16.0, 7.0), (4.0, 5.0, 2.0)  # N m, N m s/rad, N m more near standstill
LIFT_SPEED, TURN_SPEED = 0.05, 0.004  # rad/s
ROTOR = (2.1, 2.4, 0.9)  # kg m^2
COUNTS = 2**19
URDF = """<robot name="three_joints">
  <link name="base"/>
  {links}
</robot>
"""
LINK = """<link name="link_{k}"><inertial><origin xyz="{com}"/><mass value="{mass}"/>
    <inertia ixx="{i}" iyy="{i}" izz="{j}" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="joint_{k}" type="revolute"><parent link="{parent}"/><child link="link_{k}"/><origin xyz="{at}"/>
    <axis xyz="{axis}"/><limit lower="-3" upper="3" effort="400" velocity="4"/></joint>"""
LINKS = (
    {"com": "0 0.01 0.12", "mass": 12.0, "i": 0.25, "j": 0.1, "at": "0 0 0.1", "axis": "0 0 1"},
    {"com": "0.22 0 0.03", "mass": 10.0, "i": 0.3, "j": 0.28, "at": "0 0 0.3", "axis": "0 1 0"},
    {"com": "0.18 0.01 0", "mass": 6.0, "i": 0.12, "j": 0.11, "at": "0.45 0 0", "axis": "0 1 0"},
)


@dataclass(frozen=True)
class State:
    """What is wrong with an arm on a day: factors of friction and of the torque constant (3,), lost motion (3,) [rad], a
    payload [kg], and the tilt of the base [rad] about x and y."""

    friction: Array = field(default_factory=lambda: np.ones(JOINTS))
    torque_constant: Array = field(default_factory=lambda: np.ones(JOINTS))
    lost_motion: Array = field(default_factory=lambda: np.zeros(JOINTS))
    payload: float = 0.0
    tilt: tuple[float, float] = (0.0, 0.0)


Course = Callable[[float], State]  # the state of an arm on a day


def urdf() -> str:
    """The description that the vendor gives: every arm of the fleet differs from it a little."""
    names = ["base", *(f"link_{k}" for k in range(1, JOINTS))]
    links = [LINK.format(k=k + 1, parent=names[k], **link) for k, link in enumerate(LINKS)]
    return URDF.format(links="\n  ".join(links))


@dataclass(frozen=True, eq=False)
class Arm:
    """One arm: its links and friction are those of the kind within a few per cent."""

    model: pin.Model
    dry: Array
    viscous: Array
    noise: float

    @staticmethod
    def drawn(seed: int) -> Arm:
        """An arm by its number."""
        rng = np.random.default_rng([seed, 1])
        model = pin.buildModelFromXML(urdf())
        for k in range(1, JOINTS + 1):
            body = model.inertias[k]
            model.inertias[k] = pin.Inertia(
                body.mass * rng.uniform(0.95, 1.05), body.lever + rng.normal(0, 0.005, 3), body.inertia
            )
        spread = rng.uniform(0.85, 1.15, (2, JOINTS))
        return Arm(model, np.array(DRY) * spread[0], np.array(VISCOUS) * spread[1], rng.uniform(0.3, 0.5))

    def recording(self, state: State, temperature: float, seed: int) -> dict[str, Array]:
        """The columns (N,) of a recording on a day."""
        rng = np.random.default_rng([seed, 2])
        time, q, v, a = _motion(rng)
        torque = self._torque(state, q, v, a, temperature + 1.5 * (1 - np.exp(-time / 300))[:, None])
        torque = torque / state.torque_constant + _correlated(rng, q.shape, self.noise) + rng.normal(0, 0.3, JOINTS)
        step = 2 * np.pi / COUNTS
        columns = {"time": time}
        warm = temperature + rng.normal(0, 0.3, JOINTS)
        for j in range(JOINTS):
            columns[f"q_{j + 1}"] = np.round(q[:, j] / step) * step
        for j in range(JOINTS):
            columns[f"dq_{j + 1}"] = v[:, j] + rng.normal(0, 1e-3, len(time))
        for j in range(JOINTS):
            columns[f"tau_{j + 1}"] = torque[:, j]
        for j in range(JOINTS):
            columns[f"temperature_{j + 1}"] = np.full(len(time), round(warm[j], 1))
        return columns

    def _torque(self, state: State, q: Array, v: Array, a: Array, temperature: Array) -> Array:
        model = pin.Model(self.model)
        x, y = state.tilt
        model.gravity.linear = 9.81 * np.array([-np.sin(y), np.sin(x), -np.cos(x) * np.cos(y)])
        if state.payload:
            model.inertias[JOINTS] += pin.Inertia(
                state.payload, np.array([0.4, 0.0, 0.02]), 0.002 * state.payload * np.eye(3)
            )
        data = model.createData()
        links = np.array([pin.rnea(model, data, *row).copy() for row in zip(q, v, a, strict=True)])
        if state.lost_motion.any():  # the link lies on one flank of the teeth or on the other
            side = np.tanh(links / 2.0)
            lag = 0.5 * state.lost_motion * side
            rate = np.gradient(lag, 1 / RATE, axis=0)
            moved = (q - lag, v - rate, a - np.gradient(rate, 1 / RATE, axis=0))
            links = np.array([pin.rnea(model, data, *row).copy() for row in zip(*moved, strict=True)])
        colder = COMFORT - temperature
        dry = self.dry + np.array(LIFT) * np.exp(-np.abs(v) / LIFT_SPEED) + 0.03 * np.abs(links)
        friction = dry * (1 + 0.004 * colder) * np.tanh(v / TURN_SPEED) + self.viscous * np.exp(0.02 * colder) * v
        return links + np.array(ROTOR) * a + state.friction * friction


def _motion(rng: np.random.Generator) -> tuple[Array, Array, Array, Array]:
    """One of the motions of the day's work, from rest to rest: time (N,), and q, v, a (N, 3)."""
    time = np.arange(round((DURATION + 2 * STILL) * RATE)) / RATE
    share = np.clip((time - STILL) / DURATION, 0, 1)
    window, slope, bend = (np.zeros_like(time) for _ in range(3))
    ramp = np.sin(np.pi * share)
    window = ramp**4
    slope = 4 * ramp**3 * np.cos(np.pi * share) * np.pi / DURATION
    bend = (12 * ramp**2 * np.cos(np.pi * share) ** 2 - 4 * ramp**4) * (np.pi / DURATION) ** 2
    inside = (time > STILL) & (time < STILL + DURATION)
    frequency = 2 * np.pi * np.array([0.15, 0.33, 0.6])[:, None] * rng.uniform(0.9, 1.1, (3, JOINTS))
    size = np.array([0.7, 0.35, 0.15])[:, None] * rng.uniform(0.8, 1.2, (3, JOINTS))
    phase = rng.uniform(0, 2 * np.pi, (3, JOINTS))
    angle = frequency * time[:, None, None] + phase
    s = (size * np.sin(angle)).sum(axis=1)
    ds = (size * frequency * np.cos(angle)).sum(axis=1)
    dds = -(size * frequency**2 * np.sin(angle)).sum(axis=1)
    w, dw, ddw = (np.where(inside, x, 0.0)[:, None] for x in (window, slope, bend))
    return time, w * s, dw * s + w * ds, ddw * s + 2 * dw * ds + w * dds


def _correlated(rng: np.random.Generator, shape: tuple[int, ...], size: float) -> Array:
    """Noise of the torque (N, n) [N m]: white, and some that lasts for a quarter of a second."""
    from scipy.signal import lfilter

    keep = np.exp(-1 / (0.25 * RATE))
    slow = lfilter([np.sqrt(1 - keep**2)], [1, -keep], rng.normal(0, 1, shape), axis=0)
    return size * rng.normal(0, 1, shape) + 0.5 * size * np.asarray(slow)


def write(path: Path, columns: dict[str, Array]) -> None:
    """Write a recording as Parquet."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.table({name: pa.array(values) for name, values in columns.items()}), path)
