"""Real arms: what curves learn from them, beside a Gaussian process and a small network on (q, v, a), on recordings not fitted.

The last row is a bound: what any function of a joint's position, velocity, acceleration and load would leave at least of the fitted
recordings, from states that were visited twice (``physident/diagnosis/remainder/predictable.py``).

The two learn the torque that the default model leaves, as functions of the position, velocity and acceleration of all joints, from
the same rows; they are scikit-learn's, with its own choice of their sizes. Neither can be exported to a simulator, or is passive.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
import tempfile
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parents[1] / "real_arms")]

import numpy as np
from kept import UR5_GAINS, UR10E_COLUMNS, UR10E_GAINS, need_data
from numpy.typing import NDArray

import physident as pid
from physident.validation.predictions import predict

Array = NDArray[np.float64]
FOLDER = Path(__file__).parent
CACHE = Path(os.environ.get("PHYSIDENT_CACHE", Path.home() / ".cache" / "physident")) / "learned" / "real.jsonl"
ROWS = 1200  # from which a Gaussian process learns: its cost grows with their third power
SEED = 0
MODELS = (
    "default model",
    "with the effects and curves that diagnosis names",
    "default + Gaussian process",
    "default + network",
    "the least that any function of state could leave",
)


@dataclass(frozen=True, kw_only=True)
class Task:
    """Recordings to fit, to choose from and to judge on; ``faster`` where the judged motion is beyond the speeds fitted."""

    arm: str
    robot: pid.Robot
    fitted: list[pid.Recording]
    judged: list[pid.Recording]
    filter: pid.Filter
    faster: bool = False


def tasks() -> list[Task]:
    """The held-out tasks of three arms."""
    return [*_ur10e(), *_ur5(), *_tx40()]


def _ur10e() -> list[Task]:
    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    runs = pid.load_recordings(str(data / "ur-20_02_*.csv"), columns=UR10E_COLUMNS, drive_gains=UR10E_GAINS)
    return [
        Task(arm="UR10e, eight runs each left out once", robot=robot, judged=[run], filter=pid.Filter(),
             fitted=[one for one in runs if one is not run])
        for run in runs
    ]  # fmt: skip


def _ur5() -> list[Task]:
    data, robot = need_data("ur5"), pid.load_robot("ur5")

    def load(*names: str) -> list[pid.Recording]:
        return pid.load_recordings([data / f"{name}.csv.gz" for name in names], drive_gains=UR5_GAINS)

    fitted = load("move6", "move5", "move9")
    unseen = (("move8", False), ("move7", False), ("move4_fast", True))
    return [
        Task(arm=f"UR5, {name}", robot=robot, fitted=fitted, judged=load(name), filter=pid.Filter(8.0), faster=faster)
        for name, faster in unseen
    ]


def _tx40() -> list[Task]:
    from tx40_coupling import recordings  # pyright: ignore[reportMissingImports]

    robot = pid.load_robot(need_data("tx40") / "tx40_mdh_modified.urdf")
    with tempfile.TemporaryDirectory() as folder:
        files = recordings(Path(folder))
        first, second = (pid.load_recording(files[half]) for half in ("first", "second"))
    return [Task(arm="TX40, second half", robot=robot, fitted=[first], judged=[second], filter=pid.Filter())]


def errors(task: Task, cache: dict[str, tuple[pid.Estimate, pid.Estimate, Array]]) -> dict[str, list[float]]:
    """Relative error (n,) [%] of each model on the judged recordings, friction at rest at its best value inside its band."""
    key = "|".join(sorted(one.sha256 for one in task.fitted))
    if key not in cache:
        default = pid.identify(task.robot, task.fitted, filter=task.filter)
        found = pid.diagnose_motion(default, task.fitted)
        cache[key] = default, found.estimate or default, _least(found)
    default, extended, least = cache[key]
    seen, unseen = _rows(default, task.fitted), _rows(default, task.judged)
    result = {
        MODELS[0]: pid.validate(default, task.judged).relative_all,
        MODELS[1]: pid.validate(extended, task.judged).relative_all,
    }
    for name, learn in zip(MODELS[2:4], (_gaussian_process, _network), strict=True):
        left = unseen.left - learn(seen, unseen.state)
        result[name] = 100 * np.sqrt((left**2).sum(axis=0) / (unseen.measured**2).sum(axis=0))
    result[MODELS[4]] = least
    return {name: np.asarray(values).tolist() for name, values in result.items()}


def _least(found: pid.Diagnosis) -> Array:
    """Relative error (n,) [%] of the fitted recordings that no function of a joint's state could go below; NaN where it is not known."""
    shares = {one.joint: one.predictable for one in found.unexplained}
    known = [shares.get(joint + 1) for joint in range(len(found.after.relative))]
    left = [float("nan") if share is None else np.sqrt(1 - share) for share in known]
    return np.asarray(found.after.relative) * left


@dataclass(frozen=True, kw_only=True, eq=False)
class Rows:
    """Filtered rows: the ``state`` (M, 3n) of all joints, the ``measured`` torque (M, n) and what the default model has ``left``."""

    state: Array
    measured: Array
    left: Array


def _rows(model: pid.Estimate, recordings: list[pid.Recording]) -> Rows:
    states, measured, left = [], [], []
    for one in recordings:
        predictions = predict(model, [one])
        signals = pid.prepare(one.with_default_drive_gains(model.drive_gains), model.filter)
        D, delay = model.filter.decimation(signals.rate), model.filter.delay(signals.rate)
        moved = []
        for segment in signals.segments:
            values = np.column_stack([signals.q[segment], signals.v[segment], signals.a[segment]]).T
            smooth = model.filter.apply(values, signals.rate).T
            at = signals.time[segment][(np.arange(len(smooth)) + delay) * D]
            moved.append((at, smooth))
        time, state = (np.concatenate(parts) for parts in zip(*moved, strict=True))
        states.append(np.column_stack([np.interp(predictions.time, time, column) for column in state.T]))
        measured.append(predictions.measured)
        left.append(predictions.residual)
    return Rows(state=np.concatenate(states), measured=np.concatenate(measured), left=np.concatenate(left))


def _standard(seen: Rows, state: Array) -> tuple[Array, Array]:
    centre, size = seen.state.mean(axis=0), np.maximum(seen.state.std(axis=0), 1e-9)
    return (seen.state - centre) / size, (state - centre) / size


def _gaussian_process(seen: Rows, state: Array) -> Array:
    from sklearn.gaussian_process import GaussianProcessRegressor  # pyright: ignore[reportMissingImports]
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel  # pyright: ignore[reportMissingImports]

    X, wanted = _standard(seen, state)
    some = np.random.default_rng(SEED).permutation(len(X))[:ROWS]
    found = []
    for y in seen.left.T:
        kernel = ConstantKernel(1.0) * RBF(3.0) + WhiteKernel(0.3)
        process = GaussianProcessRegressor(kernel, normalize_y=True, random_state=SEED).fit(X[some], y[some])
        found.append(process.predict(wanted))
    return np.column_stack(found)


def _network(seen: Rows, state: Array) -> Array:
    from sklearn.neural_network import MLPRegressor  # pyright: ignore[reportMissingImports]

    X, wanted = _standard(seen, state)
    size = np.maximum(seen.left.std(axis=0), 1e-9)
    network = MLPRegressor(
        hidden_layer_sizes=(64, 64), alpha=1e-2, early_stopping=True, max_iter=500, random_state=SEED
    )
    return network.fit(X, seen.left / size).predict(wanted) * size


def table(found: dict[str, dict[str, list[float]]]) -> str:
    """Rows of each arm: mean relative error of each joint, per model."""
    lines = []
    for arm, models in found.items():
        rows = [f"  {name:<50}" + "".join(f"{x:8.1f}" for x in values) for name, values in models.items()]
        lines += [arm, *(row.replace("nan", "  -") for row in rows), ""]
    return "\n".join(lines).rstrip()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--resume", action="store_true", help="leave out what was judged before")
    resume = parser.parse_args().resume
    warnings.simplefilter("ignore")
    CACHE.parent.mkdir(parents=True, exist_ok=True)
    if not resume:
        CACHE.unlink(missing_ok=True)
    lines = CACHE.read_text(encoding="utf-8").splitlines() if CACHE.exists() else []
    done = {row["judged"]: row["errors"] for row in map(json.loads, lines)}
    gathered: dict[str, list[dict[str, list[float]]]] = {}
    cache: dict[str, Any] = {}
    for task in tasks():
        name = f"{task.arm} (faster than any that was fitted)" if task.faster else task.arm
        judged = task.judged[0].sha256
        if judged not in done:
            done[judged] = errors(task, cache)
            with CACHE.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps({"judged": judged, "errors": done[judged]}) + "\n")
            print(name, json.dumps(done[judged]), flush=True)
        gathered.setdefault(name, []).append(done[judged])
    found = {
        arm: {model: np.mean([row[model] for row in rows], axis=0).tolist() for model in MODELS}
        for arm, rows in gathered.items()
    }
    readme = FOLDER / "README.md"
    block = f"<!-- real -->\n```\n{table(found)}\n```\n<!-- /real -->"
    text = re.sub(r"<!-- real -->.*?<!-- /real -->", lambda _: block, readme.read_text(encoding="utf-8"), flags=re.S)
    readme.write_text(text, encoding="utf-8")
    print(table(found))


if __name__ == "__main__":
    main()
