"""Is it distance, time or speed that friction builds up over? The torque itself, about every reversal of a joint."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from kept import joint_row
from numpy.typing import NDArray
from scipy.signal import savgol_filter

import physident as pid

Array = NDArray[np.float64]
AROUND = 30  # samples to either side, 0.3 s
CLEAN = 25  # samples in one direction before and after: a reversal, not a standstill
LEVEL = 0.7  # of the friction that is reached in the end
GROUPS = 3  # by acceleration


def reversals(estimate: pid.Estimate, recordings: list[pid.Recording]) -> dict[str, Any]:
    """Where dry friction has reached 70 % after a reversal, slow and fast ones apart; joint 6's median ``curves``."""
    dry = [_dry(estimate, pid.prepare(r, estimate.filter)) for r in recordings]
    table, curves = [], []
    for j in range(estimate.model.robot.n):
        groups = _groups([turn for one in dry for turn in _turns(*one, j)])
        reached = [_reached(group) for group in groups]
        table.append({"joint": j + 1, "count": sum(g["count"] for g in groups), "groups": reached})
        curves = groups
    ratios = {k: [t["groups"][-1][k] / t["groups"][0][k] for t in table] for k in ("travel", "time", "speed")}
    rows = [
        "where friction has built up to 70 % after a reversal: fastest third of reversals over slowest third",
        joint_row("joint", range(1, len(table) + 1), 0),
        joint_row("ratio of accelerations", [t["groups"][-1]["acceleration"] / t["groups"][0]["acceleration"] for t in table]),
        *(joint_row(f"ratio of {k} since the reversal", v) for k, v in ratios.items()),
        joint_row("travel, slowest third [mrad]", [1e3 * t["groups"][0]["travel"] for t in table]),
        joint_row("travel, fastest third [mrad]", [1e3 * t["groups"][-1]["travel"] for t in table]),
    ]  # fmt: skip
    return {"table": table, "curves": curves, "rows": rows}


def _dry(estimate: pid.Estimate, signals: pid.Signals) -> tuple[Array, Array, Array]:
    """Position, its derivative, and what is left of the unfiltered torque (N, n) without links, rotors and viscous friction.

    The velocity is that of the positions: the measured one would be judged by itself.
    """
    v, a = (
        np.asarray(savgol_filter(signals.q, width, 4, deriv=order, delta=1 / signals.rate, axis=0))
        for order, width in ((1, 9), (2, 15))
    )
    model = estimate.model
    load = model.refer(replace(signals, v=v, a=a)).load
    assert load is not None
    assert signals.torque is not None
    smooth = model.parameters("viscous_friction") * v + model.parameters("torque_offset")
    return signals.q, v, signals.torque - load - smooth


def _turns(q: Array, v: Array, dry: Array, j: int) -> list[tuple[float, Array, Array, Array]]:
    """Acceleration, friction, travel and speed about each clean reversal of a joint, the new direction positive."""
    found = []
    for i in np.flatnonzero(np.sign(v[1:, j]) * np.sign(v[:-1, j]) < 0):
        if not AROUND <= i < len(v) - AROUND:
            continue
        before, after = v[i - CLEAN : i - 1, j], v[i + 2 : i + 1 + CLEAN, j]
        if (before * before[0] > 0).all() and (after * after[0] > 0).all():
            own = slice(i, i + AROUND)
            sign = np.sign(after[0])
            speed = sign * v[own, j]
            pace = float(speed[5] / 0.05)
            found.append((pace, sign * dry[own, j], sign * (q[own, j] - q[i, j]), speed))
    return found


def _groups(turns: list[tuple[float, Array, Array, Array]]) -> list[dict[str, Any]]:
    """Medians over thirds of the reversals, slow ones first."""
    order = np.argsort([t[0] for t in turns])
    result = []
    for part in np.array_split(order, GROUPS):
        pace, friction, travel, speed = (np.median([turns[i][k] for i in part], axis=0) for k in range(4))
        result.append(
            {"acceleration": float(pace), "count": len(part), "friction": friction, "travel": travel, "speed": speed,
             "time": np.arange(AROUND) / 100}
        )  # fmt: skip
    return result


def _reached(group: dict[str, Any]) -> dict[str, float]:
    """Travel, time and speed at which the friction has reached its level."""
    friction = group["friction"]
    wanted = LEVEL * float(np.median(friction[-10:]))
    at = int(np.argmax(friction >= wanted))
    share = (wanted - friction[at - 1]) / (friction[at] - friction[at - 1])
    result = {"acceleration": group["acceleration"], "friction": wanted}
    for k in ("travel", "time", "speed"):
        result[k] = float(group[k][at - 1] + share * (group[k][at] - group[k][at - 1]))
    return result
