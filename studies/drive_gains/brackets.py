"""Between which gains the truth lies when torque and current both have errors, and no load is known."""

from __future__ import annotations

import csv
import gzip
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.dynamics.dry_sign import smooth_sign

MOVEMENTS = ("move4_fast", "move5", "move6", "move7", "move8", "move9")
GAIN_SETS = {"controller": (10.7, 10.7, 10.7, 10.2, 10.2, 10.2), "fitted by hand": (7.5, 6.8, 7.1, 2.8, 3.2, 3.4)}
CUTOFF = 8.0  # Hz
BLOCK = 3.0  # s, several times the memory of the residuals
RESAMPLES = 500
Array = NDArray[np.float64]


def ur5_brackets(folder: Path) -> dict[str, Any]:
    """For each joint the gains that regression in either direction gives, with the drive's own torque and without.

    With the drive's own torque (friction, rotor inertia, offset) taken out of both, current = torque / K + error gives K too large where the torque is wrong, torque =
    K current + error gives it too small where the current is: the truth lies between (Frisch, 1934).
    """
    robot = pid.load_robot("ur5")
    filter = pid.Filter(CUTOFF)
    pieces = [_channels(robot, folder / f"{name}.csv.gz", filter) for name in MOVEMENTS]
    torque, current, v, sign, a = (np.concatenate([piece[k] for piece in pieces]) for k in range(5))
    drives = [np.column_stack([v[:, j], sign[:, j], a[:, j], np.ones(len(v))]) for j in range(robot.n)]
    rows = int(BLOCK * 4 * CUTOFF)
    blocks = np.concatenate([1000 * i + np.arange(len(p[0])) // rows for i, p in enumerate(pieces)])
    index = [np.flatnonzero(blocks == label) for label in np.unique(blocks)]
    rng = np.random.default_rng(0)
    draws = [np.concatenate([index[k] for k in rng.integers(0, len(index), len(index))]) for _ in range(RESAMPLES)]
    result: dict[str, Any] = {
        key: [] for key in ("lower", "upper", "lowest", "highest", "no_friction", "rms_ratio", "correlation")
    }
    for j, drive in enumerate(drives):
        t, i = torque[:, j], current[:, j]
        lower, upper, correlation = _bracket(t, i, drive)
        again = np.array([_bracket(t[d], i[d], drive[d])[:2] for d in draws])
        result["lower"].append(lower)
        result["upper"].append(upper)
        result["lowest"].append(float(np.quantile(again[:, 0], 0.025)))
        result["highest"].append(float(np.quantile(again[:, 1], 0.975)))
        result["no_friction"].append(float(t @ i / (i @ i)))
        result["rms_ratio"].append(float(np.linalg.norm(t) / np.linalg.norm(i)))
        result["correlation"].append(correlation)
    result["unexplained_percent"] = {
        name: _unexplained(torque, current * gains, drives) for name, gains in GAIN_SETS.items()
    }
    return result | {"movements": list(MOVEMENTS), "cutoff": CUTOFF}


def _bracket(torque: Array, current: Array, drive: Array) -> tuple[float, float, float]:
    both = np.column_stack([torque, current])
    t, i = (both - drive @ np.linalg.lstsq(drive, both, rcond=None)[0]).T
    return float(t @ i / (i @ i)), float(t @ t / (t @ i)), float(t @ i / np.sqrt((t @ t) * (i @ i)))


def _unexplained(torque: Array, measured: Array, drives: list[Array]) -> list[float]:
    """Share [%] of gain times current that the controller's torque and the drive's own leave."""
    left = []
    for j, drive in enumerate(drives):
        rest = measured[:, j] - torque[:, j]
        rest = rest - drive @ np.linalg.lstsq(drive, rest, rcond=None)[0]
        left.append(float(100 * np.linalg.norm(rest) / np.linalg.norm(measured[:, j])))
    return left


def _channels(robot: pid.Robot, path: Path, filter: pid.Filter) -> tuple[Array, ...]:
    """Filtered controller torque [N m], current [A], velocity, its sign, acceleration (M, n), over the rows kept."""
    recording = pid.load_recording(path, drive_gains=[1.0] * robot.n)
    with gzip.open(path, "rt") as stream:
        table = list(csv.DictReader(stream))
    own = np.array([[float(row[f"target_torque_{j}"]) for j in range(1, robot.n + 1)] for row in table])
    if recording.rejected or len(own) != len(recording.time):
        raise SystemExit(f"{path}: rows were left out, so that the controller's torque does not line up")
    signals = pid.prepare(recording, filter)
    target = pid.prepare(replace(recording, effort=own, effort_kind="torque", drive_gains=None), filter)
    if len(signals.starts) > 1:
        raise SystemExit(f"{path}: has gaps, expected one piece")
    assert signals.torque is not None
    assert target.torque is not None
    sign = smooth_sign(signals.v, 0.01)
    return tuple(
        filter.apply(np.ascontiguousarray(x.T), signals.rate).T
        for x in (target.torque, signals.torque, signals.v, sign, signals.a)
    )  # pyright: ignore[reportReturnType]
