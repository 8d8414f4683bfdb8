"""Sensors: the recorded signals of a true motion and torque, with the errors of real instruments."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.files import read_json, write_json
from physident.recordings.formats.table import Table
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
PerJoint = float | tuple[float, ...]
SCHEMA = "physident.sensors/1"
VELOCITIES = ("tachometer", "encoder", "none")
EFFORTS = ("torque", "current")
MAX_FILE = 1_000_000  # bytes
LARGEST = 1e9  # of any setting: sums and products of noise stay finite
SLOWEST, FASTEST = 10.0, 1e5  # Hz: a slower clock is no recording of a motion
GLITCHES = (1e290, -1e290, 1e-153)  # values that an interrupted write leaves in a file


@dataclass(frozen=True)
class Warming:
    """Temperature of every joint: start + rise (1 - exp(-t / time_constant)); [degC], [K], [s]."""

    start: float = 25.0
    rise: float = 15.0
    time_constant: float = 1800.0

    def __post_init__(self) -> None:
        if not np.isfinite([self.start, self.rise]).all() or not 0 < self.time_constant < math.inf:
            raise InputError(f"sensors: temperature is {self}, expected finite numbers and a positive time_constant")

    def at(self, time: Array, n: int) -> Array:
        """Temperature (N, n) [degC] at times (N,) [s]."""
        return np.tile((self.start + self.rise * -np.expm1(-time / self.time_constant))[:, None], (1, n))


@dataclass(frozen=True)
class Sensors:
    """The instruments of an arm; ideal ones at 125 Hz by default. Numbers are for all joints or (n,), one for each.

    ``rate`` [Hz], ``jitter`` [s] standard deviation of the sampling instants, which the clock shows. ``delay`` [s] by
    which the effort arrives late. ``encoder_step`` [rad|m] between two counts. ``velocity``: "tachometer" with
    ``velocity_noise`` [rad/s|m/s], "encoder" (difference of the last two counts over their time) or "none".
    ``effort``: "torque" or "current", I = tau / (K_T G), with white ``current_noise`` [A] and white
    ``torque_constant_noise``, a share of K_T (thesis eq. 4.7-4.9: tau = I_noisy K_T,noisy G); white ``torque_noise``
    [N m|N] on top. ``drive_gains`` K_T G [N m/A], by default those of the robot's drives. ``dropped`` and ``corrupted``
    are shares of the rows. ``temperature`` adds that channel, and warms the arm.
    """

    rate: float = 125.0
    jitter: float = 0.0
    delay: float = 0.0
    encoder_step: PerJoint = 0.0
    velocity: str = "tachometer"
    velocity_noise: PerJoint = 0.0
    effort: str = "torque"
    current_noise: PerJoint = 0.0
    torque_constant_noise: PerJoint = 0.0
    torque_noise: PerJoint = 0.0
    drive_gains: tuple[float, ...] | None = None
    dropped: float = 0.0
    corrupted: float = 0.0
    temperature: Warming | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name in ("velocity", "effort", "temperature") or (field.name, value) == ("drive_gains", None):
                continue
            several = field.name not in ("rate", "jitter", "delay", "dropped", "corrupted")
            if not _numbers(value) or (isinstance(value, tuple) and not several) or (np.array(value) < 0).any():
                raise InputError(
                    f"sensors: {field.name} is {value!r}, expected numbers up to {LARGEST:g}, none negative"
                )
        for name, known in (("velocity", VELOCITIES), ("effort", EFFORTS)):
            if getattr(self, name) not in known:
                raise InputError(f"sensors: {name} is {getattr(self, name)!r}, expected one of {', '.join(known)}")
        if not isinstance(self.drive_gains, tuple | None):
            raise InputError(f"sensors: drive_gains is {self.drive_gains}, expected a list, one for each joint [N m/A]")
        for name in ("dropped", "corrupted"):
            if getattr(self, name) >= 0.5:
                raise InputError(f"sensors: {name} is {getattr(self, name)}, expected a share of the rows below 0.5")
        if not SLOWEST <= self.rate <= FASTEST:
            raise InputError(f"sensors: rate is {self.rate} Hz, expected {SLOWEST:g} to {FASTEST:g} Hz")
        if self.temperature is not None and not isinstance(self.temperature, Warming):
            raise InputError(f"sensors: temperature is {self.temperature!r}, expected start, rise and time_constant")

    def read(self, robot: Robot, truth: Signals, duration: float, rng: np.random.Generator) -> Table:
        """The table that the instruments record of the true motion and drive torque over ``duration`` [s].

        ``truth`` is uniform in time and reaches at least as far. Raises InputError for currents of a robot
        without drives.
        """
        count = math.floor(duration * self.rate + 1e-6) + 1
        period = 1 / self.rate
        # instants stay in order: a jitter beyond that would be a row out of order, which is another fault
        shift = np.clip(self.jitter * rng.standard_normal(count), -0.4 * period, 0.4 * period)
        time = np.clip(period * np.arange(count) + shift, 0.0, truth.time[-1])
        step = self._per_joint(self.encoder_step, robot)
        q = _quantised(_at(truth, "q", time), step)
        channels = {"q": q}
        if self.velocity == "encoder":
            steps = np.diff(q, axis=0) / np.diff(time)[:, None]
            channels["dq"] = np.concatenate([np.zeros((1, robot.n)), steps])
        elif self.velocity == "tachometer":
            noise = self._per_joint(self.velocity_noise, robot) * rng.standard_normal(q.shape)
            channels["dq"] = _at(truth, "v", time) + noise
        effort = self._effort(robot, _at(truth, "torque", np.maximum(time - self.delay, 0.0)), rng)
        channels["tau" if self.effort == "torque" else "current"] = effort
        if self.temperature is not None:
            channels["temperature"] = self.temperature.at(time, robot.n)
        return self._faults(time, channels, rng)

    def check(self, robot: Robot) -> None:
        """Raises InputError for settings that are not one or one for each of the robot's joints, and for currents of a
        robot without drives."""
        for name in ("encoder_step", "velocity_noise", "current_noise", "torque_constant_noise", "torque_noise"):
            self._per_joint(getattr(self, name), robot)
        if self.effort == "current" or np.any(self.current_noise):
            self.gains(robot)

    def gains(self, robot: Robot) -> Array:
        """Drive gains K_T G (n,) [N m/A]; raises InputError where neither these sensors nor the robot state any."""
        if self.drive_gains is not None:
            if len(self.drive_gains) != robot.n or 0 in self.drive_gains:
                raise InputError(
                    f"sensors: drive_gains are {self.drive_gains}, expected {robot.n} positive numbers [N m/A]"
                )
            return np.array(self.drive_gains, dtype=float)
        if robot.drives is None:
            raise InputError(f"sensors: currents need drives, robot {robot.name} states none; give drive_gains [N m/A]")
        return np.array([drive.torque_constant * drive.gear_ratio for drive in robot.drives])

    def _effort(self, robot: Robot, torque: Array, rng: np.random.Generator) -> Array:
        current_noise = self._per_joint(self.current_noise, robot)
        constant_noise = self._per_joint(self.torque_constant_noise, robot)
        noise = rng.standard_normal((3, *torque.shape))
        if self.effort == "current" or current_noise.any():
            gains = self.gains(robot)
            torque = gains * (torque / gains + current_noise * noise[0])
        torque = torque * (1 + constant_noise * noise[1]) + self._per_joint(self.torque_noise, robot) * noise[2]
        return torque / self.gains(robot) if self.effort == "current" else torque

    def _faults(self, time: Array, channels: dict[str, Array], rng: np.random.Generator) -> Table:
        """The table without the rows that were dropped, with some corrupted."""
        joints = range(1, channels["q"].shape[1] + 1)
        names = ("time", *(f"{name}_{j}" for name in channels for j in joints))
        values = np.column_stack([time, *channels.values()])
        values = values[rng.uniform(size=len(values)) >= self.dropped]
        bad = np.flatnonzero(rng.uniform(size=len(values)) < self.corrupted)
        values[bad, rng.integers(values.shape[1], size=len(bad))] = rng.choice(GLITCHES, size=len(bad))
        return Table(values, np.arange(2, len(values) + 2), names)

    def _per_joint(self, value: PerJoint, robot: Robot) -> Array:
        numbers = np.broadcast_to(value, (robot.n,)) if np.ndim(value) == 0 else np.array(value, dtype=float)
        if numbers.shape != (robot.n,):
            raise InputError(
                f"sensors: {value} has {len(numbers)} values, expected one or {robot.n}, one for each joint"
            )
        return numbers

    def save(self, path: str | Path) -> None:
        """Write the settings as JSON (schema physident.sensors/1), whole or not at all."""
        write_json(path, {"schema": SCHEMA, **asdict(self)})


def load_sensors(path: str | Path) -> Sensors:
    """Sensors from a JSON file (schema physident.sensors/1) with any of the settings of ``Sensors``; raises InputError
    where it is missing, no JSON, of another schema, or names a setting that does not exist."""
    data = read_json(path, MAX_FILE, "settings of sensors", SCHEMA)
    del data["schema"]
    unknown = sorted(set(data) - {field.name for field in fields(Sensors)})
    if unknown:
        known = ", ".join(field.name for field in fields(Sensors))
        raise InputError(f"{path}: {unknown[0]!r} is no setting of sensors, expected some of {known}")
    settings: dict[str, Any] = {key: tuple(x) if isinstance(x, list) else x for key, x in data.items()}
    try:
        if isinstance(settings.get("temperature"), dict):
            settings["temperature"] = Warming(**settings["temperature"])
        return Sensors(**settings)
    except TypeError:
        expected = "start [degC], rise [K], time_constant [s]"
        raise InputError(f"{path}: temperature is {data['temperature']}, expected {expected}") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _numbers(value: Any) -> bool:
    numbers = value if isinstance(value, tuple) else (value,)
    return all(isinstance(x, int | float) and not isinstance(x, bool) and abs(x) <= LARGEST for x in numbers)


def _quantised(values: Array, step: Array) -> Array:
    safe = np.where(step > 0, step, 1.0)
    return np.where(step > 0, safe * np.round(values / safe), values)


def _at(truth: Signals, channel: str, time: Array) -> Array:
    """A true channel (N, n) at some instants: exact on the grid, by cubic pieces between."""
    values = getattr(truth, channel)
    place = time * truth.rate
    nearest = np.round(place).astype(np.intp)
    if np.abs(place - nearest).max() < 1e-6:
        return values[nearest]
    from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

    if channel == "torque":
        return PchipInterpolator(truth.time, values)(time)
    slope = truth.v if channel == "q" else truth.a
    return CubicHermiteSpline(truth.time, values, slope)(time)
