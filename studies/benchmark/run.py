"""Score predictions of joint torque on held-out recordings of real arms: `run.py`, `run.py --tasks DIR`, `run.py --entry DIR NAME`."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import keep
from numpy.typing import NDArray
from tasks import Task, tasks

import physident as pid

HERE = Path(__file__).resolve().parent
METHODS = ("ols", "wls", "physical")
PLAIN = ["rigid_body"]  # any effects: only the filtered torque and its rows are used
Array = NDArray[np.float64]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--tasks", type=Path, metavar="DIR", help="write train and test recordings of every task as CSV"
    )
    parser.add_argument("--entry", nargs=2, metavar=("DIR", "NAME"), help="score DIR/TASK.csv: time,tau_1..tau_n")
    given = parser.parse_args()
    if given.tasks is not None:
        for task in tasks():
            write_task(task, given.tasks / task.name)
        return
    path = HERE / "results.json"
    entries: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))["entries"] if path.is_file() else {}
    if given.entry is not None:
        folder, name = given.entry
        entries[name] = {
            task.name: score(task, *read_entry(Path(folder) / f"{task.name}.csv", task)) for task in tasks()
        }
    else:
        entries |= {f"physident {method}": {} for method in METHODS}
        for task in tasks():
            for method in METHODS:
                entries[f"physident {method}"][task.name] = score(task, *predicted(task, method))
    keep(HERE, {"entries": entries}, table(entries))


def write_task(task: Task, folder: Path) -> None:
    """The recordings of a task, with torques [N m], and the robot's URDF."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.urdf").write_text(task.robot.urdf, encoding="utf-8")
    for name, run in [*((f"train_{k}", r) for k, r in enumerate(task.train, 1)), ("test", task.test)]:
        as_torque = pid.Recording.from_arrays(run.time, run.q, run.torque, run.dq, source=run.source)
        frame = as_torque.to_pandas()
        if name == "test":  # an entry predicts the torque and does not see it
            frame = frame[[column for column in frame.columns if not column.startswith("tau_")]]
        frame.to_csv(folder / f"{name}.csv", index=False)


def read_entry(path: Path, task: Task) -> tuple[Array, Array]:
    """Times (N,) [s] and predicted torques (N, n) [N m] of an entry; ends with one line for a file that does not fit."""
    try:
        rows = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    except (OSError, ValueError) as error:
        sys.exit(f"{path}: {error}; expected a header and rows time,tau_1..tau_{task.robot.n}")
    if rows.shape[1] != task.robot.n + 1 or not np.isfinite(rows).all() or (np.diff(rows[:, 0]) <= 0).any():
        sys.exit(
            f"{path}: {rows.shape[1]} columns, expected increasing times and {task.robot.n} finite torques in each row"
        )
    return rows[:, 0], rows[:, 1:]


def predicted(task: Task, method: str) -> tuple[Array, Array]:
    """Times (N,) [s] and torques (N, n) [N m] that the default model predicts, fitted by a method."""
    filter = pid.Filter(cutoff=task.cutoff)
    estimate = pid.identify(task.robot, task.train, method=method, filter=filter)
    signals = pid.prepare(task.test, filter)
    return signals.time, estimate.model.torque(signals)


def score(task: Task, time: Array, torque: Array) -> dict[str, list[float]]:
    """Relative error [%] and RMS error [N m] of each joint: both sides filtered alike, over the moving part."""
    filter = pid.Filter(cutoff=task.cutoff)
    signals = pid.prepare(task.test, filter)
    if time[0] > signals.time[0] + 0.1 or time[-1] < signals.time[-1] - 0.1:
        sys.exit(
            f"{task.name}: predicted from {time[0]:.1f} to {time[-1]:.1f} s, expected {signals.time[0]:.1f} to {signals.time[-1]:.1f} s"
        )
    guess = np.column_stack([np.interp(signals.time, time, column) for column in torque.T])
    effects = pid.make_effects(PLAIN)
    sides = [
        pid.build_regressor(task.robot, effects, [side], filter).torque
        for side in (signals, replace(signals, torque=guess))
    ]
    error = np.linalg.norm(sides[0] - sides[1], axis=0)
    return {
        "relative_percent": (100 * error / np.linalg.norm(sides[0], axis=0)).tolist(),
        "rms": (error / np.sqrt(len(sides[0]))).tolist(),
    }


def table(entries: dict[str, Any]) -> str:
    """Each arm's mean relative error [%] of each joint over its tasks, a row an entry."""
    rows = ["relative error [%] of held-out torque, mean over the tasks of an arm; joints 1 to n"]
    arms = dict.fromkeys(name.split("_")[0] for tasks_ in entries.values() for name in tasks_)
    for arm in arms:
        for entry, of in entries.items():
            means = np.mean([one["relative_percent"] for name, one in of.items() if name.split("_")[0] == arm], axis=0)
            rows.append(f"{arm:<8}{entry:<24}" + "".join(f"{x:8.1f}" for x in means))
    return "\n".join(rows)


if __name__ == "__main__":
    main()
