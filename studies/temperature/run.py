"""What does a measured temperature explain of the friction of a Kinova Gen3 that was recorded at 24 and at 40 degrees?"""

# fast
from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import numpy as np
import pyarrow.csv as csv
from kept import keep, need_data
from numpy.typing import NDArray
from scipy.signal import firwin

from physident.estimation.uncertainty import t_quantile

Array = NDArray[np.float64]
RUNS = {"cold": "RecordTrajectory_quadratic", "middle": "opti_traj_testing2", "warm": "RunTrajectory1"}
JOINTS, RATE, CUTOFF = 7, 1000.0, 5.0  # Hz
STEP = 20  # samples of 1 kHz between two rows, ten for each period of the cutoff
TURN = 0.01  # rad/s over which the sign of the velocity turns
MOVING = 0.02  # rad/s: slower, and friction holds anything within its band
SLOPES = np.linspace(-0.1, 0.1, 401)  # relative change of viscous friction for each degree
BLOCKS = 8  # of each recording, for standard errors
COMMON = 3  # columns that all recordings share: offset, torque and acceleration; then come those of friction


@dataclass(frozen=True, eq=False)
class Rows:
    """One joint in one recording: ``current`` (N,) [N m] of the motor, the ``columns`` (N, 5) that should explain it (one, torque,
    acceleration, sign and velocity), the joint's ``temperature`` [degC], and whether its torque was measured by a sensor."""

    current: Array
    columns: Array
    temperature: float
    sensor: bool


def main() -> None:
    folder = need_data("kinova_gen3")
    runs = {name: read(folder / f"{file}.csv.gz") for name, file in RUNS.items()}
    joints = [{name: run[j] for name, run in runs.items()} for j in range(JOINTS)]
    friction = []
    for joint in joints:
        value, half = friction_of_each(list(joint.values()))
        friction.append(
            {
                name: {
                    "temperature": run.temperature, "sensor": run.sensor,
                    "coulomb": [float(value[k, 0]), float(half[k, 0])], "viscous": [float(value[k, 1]), float(half[k, 1])],
                }
                for k, (name, run) in enumerate(joint.items())
            }
        )  # fmt: skip
    slope, half = slope_of([list(joint.values()) for joint in joints])
    results = {
        "friction": friction, "slope": slope, "slope_half_width": half,
        "left_out": {name: left_out(joints, name) for name in RUNS},
    }  # fmt: skip
    keep(Path(__file__).parent, results, table(results))


def read(path: Path) -> list[Rows]:
    """Each joint's rows: both sides low-passed by the same filter, moving rows only."""
    data = csv.read_csv(path)
    found = []
    for j in range(1, JOINTS + 1):
        q, current, model, sensor, warm = (
            data[f"{name}{j}"].to_numpy() for name in ("Position", "TorqueCur", "Torque", "TorqueSm", "Temp")
        )
        taps = np.asarray(firwin(2 * round(1.5 * RATE / CUTOFF) // 2 + 1, 4 * CUTOFF, fs=RATE), dtype=np.float64)
        smooth = np.convolve(np.pad(q, len(taps) // 2, mode="edge"), taps, mode="valid")
        v, a = np.gradient(smooth, 1 / RATE), np.gradient(np.gradient(smooth, 1 / RATE), 1 / RATE)
        torque = sensor if sensor.std() > 0 else model
        columns = np.column_stack(
            [np.ones_like(v), torque, a, np.tanh(v / TURN), v, current, 1.0 * (np.abs(v) > MOVING)]
        )
        rows = low_passed(np.asarray(columns, dtype=np.float64))
        rows = rows[rows[:, -1] > 0.9]
        found.append(Rows(rows[:, 5], rows[:, :5], float(warm.mean()), bool(sensor.std() > 0)))
    return found


def low_passed(columns: Array) -> Array:
    """Every twentieth row of columns (N, k) after the filter, whole windows only."""
    taps = np.asarray(firwin(round(RATE / CUTOFF) + 1, CUTOFF, fs=RATE), dtype=np.float64)
    return np.column_stack([np.convolve(column, taps, mode="valid") for column in columns.T])[::STEP]


def left_out(joints: list[dict[str, Rows]], name: str) -> dict[str, Any]:
    """How well the friction of a recording is predicted from the other two, with and without a temperature slope."""
    others = [[run for other, run in joint.items() if other != name] for joint in joints]
    slope, half = slope_of(others)
    found: dict[str, Any] = {
        "slope": slope,
        "slope_half_width": half,
        "without": [],
        "with": [],
        "own_friction": [],
        "size": [],
    }
    for joint, training in zip(joints, others, strict=True):
        run, middle = joint[name], middle_of(training)
        for label, s in (("without", 0.0), ("with", slope)):
            x = solved([designed(one, middle, s) for one in training], training)
            found[label].append(rms(run.current - designed(run, middle, s) @ x))
        # friction of its own beside all else of the others: as much as any cause of changed friction could explain
        left = run.current - run.columns[:, :COMMON] @ solved([one.columns for one in training], training)[:COMMON]
        own = run.columns[:, COMMON:]
        found["own_friction"].append(rms(left - own @ np.linalg.lstsq(own, left, rcond=None)[0]))
        found["size"].append(rms(run.current))
    return found


def slope_of(joints: list[list[Rows]]) -> tuple[float, float]:
    """The relative change of viscous friction for each degree that explains all joints best, the same for all because they have
    one grease, and the half-width of its 95 % interval, by leaving out a joint at a time."""
    costs = np.array([[_cost(runs, s) for s in SLOPES] for runs in joints])
    best = float(SLOPES[costs.sum(axis=0).argmin()])
    each = SLOPES[(costs.sum(axis=0) - costs).argmin(axis=1)] - best
    return best, float(t_quantile(len(joints)) * np.sqrt((len(joints) - 1) / len(joints) * np.square(each).sum()))


def _cost(runs: list[Rows], slope: float) -> float:
    """The squared error of some recordings of a joint, over the smallest that friction of their own leaves."""
    middle, y = middle_of(runs), np.concatenate([run.current for run in runs])
    A = np.concatenate([designed(run, middle, slope) for run in runs])
    left = y - A @ np.linalg.lstsq(A, y, rcond=None)[0]
    return float(left @ left / np.square(y - y.mean()).sum())


def middle_of(runs: list[Rows]) -> float:
    """The mean temperature [degC] of some recordings."""
    return float(np.mean([run.temperature for run in runs]))


def solved(columns: list[Array], runs: list[Rows]) -> Array:
    """Least squares of some recordings together."""
    found = np.linalg.lstsq(np.concatenate(columns), np.concatenate([one.current for one in runs]), rcond=None)[0]
    return np.asarray(found, dtype=np.float64)


def designed(run: Rows, middle: float, slope: float) -> Array:
    """The columns of a recording, with the viscous one changed by a relative ``slope`` for each degree beside the ``middle``."""
    return run.columns * np.r_[np.ones(COMMON + 1), max(0.0, 1 + slope * (run.temperature - middle))]


def friction_of_each(runs: list[Rows]) -> tuple[Array, Array]:
    """Coulomb and viscous friction (R, 2) of each recording beside an offset, a gain and an inertia that all share, and the half-widths
    of their 95 % intervals, by leaving out a block at a time."""
    columns = [
        np.column_stack([run.columns[:, :COMMON], np.kron(np.eye(len(runs))[k], run.columns[:, COMMON:])])
        for k, run in enumerate(runs)
    ]
    A, y = np.concatenate(columns), np.concatenate([run.current for run in runs])
    ends = np.cumsum([0, *(len(run.current) for run in runs)])
    parts = [part for k in range(len(runs)) for part in np.array_split(np.arange(ends[k], ends[k + 1]), BLOCKS)]
    value = np.asarray(np.linalg.lstsq(A, y, rcond=None)[0], dtype=np.float64)
    each = [np.linalg.lstsq(np.delete(A, part, axis=0), np.delete(y, part), rcond=None)[0] - value for part in parts]
    error = np.sqrt((len(parts) - 1) / len(parts) * np.square(each).sum(axis=0))
    half = t_quantile(BLOCKS) * error  # a recording's friction is known from its own blocks
    return value[COMMON:].reshape(-1, 2), half[COMMON:].reshape(-1, 2)


def rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))


def table(r: dict[str, Any]) -> str:
    names = list(RUNS)
    rows = [
        "Friction in each recording, 95 % interval (* the controller's torque, where no sensor was recorded)",
        f"{'joint':<7}{'':<9}{'degC':>6}{'Coulomb N m':>18}{'viscous N m s/rad':>20}",
    ]
    for j, joint in enumerate(r["friction"], 1):
        for name in names:
            one = joint[name]
            texts = [f"{one[key][0]:.2f} ± {one[key][1]:.2f}" for key in ("coulomb", "viscous")]
            first, mark = j if name == names[0] else "", name + ("" if one["sensor"] else "*")
            rows.append(f"{first:<7}{mark:<9}{one['temperature']:>6.1f}{texts[0]:>18}{texts[1]:>20}")
    rows += [
        "",
        f"Viscous friction of all joints together: {100 * r['slope']:+.1f} ± {100 * r['slope_half_width']:.1f} % a degree",
        "",
        "Error [N m] on the recording that was left out: friction of the other two; with their temperature slope; with friction of its own",
    ]
    for name in names:
        one = r["left_out"][name]
        before, after, own = (np.array(one[key]) ** 2 for key in ("without", "with", "own_friction"))
        edge = ", the end of what was searched" if np.isclose(abs(one["slope"]), SLOPES[-1]) else ""
        text = f"{100 * one['slope']:+.1f} ± {100 * one['slope_half_width']:.1f}"
        rows.append(f"{name}, slope from the others {text} % a degree{edge}")
        for label, key in (("without", "without"), ("with slope", "with"), ("own friction", "own_friction")):
            rows.append(f"  {label:<22}" + "".join(f"{value:>8.2f}" for value in one[key]))
        rows.append(
            f"  {'slope takes, %':<22}"
            + "".join(f"{100 * (1 - a / b):>8.0f}" for a, b in zip(after, before, strict=True))
            + f"   all joints {100 * (1 - (after / before).mean()):.0f}; friction of its own {100 * (1 - (own / before).mean()):.0f}"
        )
    return "\n".join(rows)


if __name__ == "__main__":
    main()
