"""Other tools on the benchmark's tasks, and other ways to design a motion: `run.py`, or parts of it: `run.py arms motions`."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import numpy as np
from judged import violations

import physident as pid
from studies.excitation.others import finite_differences, genetic_alone
from studies.kept import ROOT, joint_row, keep  # sets its threads before numpy loads

FOLDER = Path(__file__).parent
BUILD = ROOT / "build" / "peers"  # tasks, and the predictions that the benchmark scores
CUTOFFS = {"ur10e": 5.0, "ur5": 8.0, "ur10": 3.0, "panda": 3.0}  # Hz, the benchmark's
PROGRAMS = {
    "plain ols": "plain.py ols",
    "plain wls": "plain.py wls",
    "plain sdp": "plain.py sdp",
    "figaroh fit": "figaroh_arm.py fit",
    "figaroh wls": "figaroh_arm.py wls",
    "figaroh physical_fit": "figaroh_arm.py physical_fit",
    "physident wls": "ours.py wls",
    "physident physical": "ours.py physical",
    "physident diagnosed": "ours.py diagnosed",
}
VERSIONS = ("figaroh", "pin", "numpy", "scipy", "cvxpy", "clarabel", "cvxopt", "pymoo", "mujoco")
STAGES = ("imports", "read", "regressor", "fit", "diagnose")
SECONDS, SEEDS = (6.0, 60.0), 3  # of processor time for a motion: what physident's design takes, and ten times that


def arms() -> dict[str, Any]:
    """Every program on every task of the benchmark, each in its own process."""
    benchmark = ROOT / "studies" / "benchmark" / "run.py"
    subprocess.run([sys.executable, benchmark, "--tasks", BUILD / "tasks"], check=True)
    found: dict[str, Any] = {name: {} for name in PROGRAMS}
    for task in sorted((BUILD / "tasks").iterdir()):  # all programs in turn, so that a busy machine is busy for all
        cutoff = CUTOFFS[task.name.split("_")[0]]
        for name, call in PROGRAMS.items():
            program, method = call.split()
            out = BUILD / name.replace(" ", "_") / f"{task.name}.csv"
            out.parent.mkdir(parents=True, exist_ok=True)
            command = [sys.executable, FOLDER / program, task, method, cutoff, out]
            done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
            if done.returncode:
                sys.exit(f"{name} on {task.name}: {done.stderr.strip().splitlines()[-1]}")
            answer = json.loads(done.stdout)
            answer |= violations(*(np.array(answer.pop(kind)) for kind in ("links", "viscous", "dry")))
            found[name][task.name] = answer
            print(f"{name:24}{task.name:28}{sum(answer['seconds'].values()):8.1f} s", flush=True)
    return found


def motions() -> dict[str, Any]:
    """Condition numbers of motions designed for a UR5 in the same processor time: the problem of studies/excitation."""
    robot = pid.load_robot("ur5")
    ways = {"SLSQP, finite differences": finite_differences, "genetic algorithm (pymoo)": genetic_alone}
    found: dict[str, Any] = {
        name: {f"{s:g}": [way(robot, s, 1000 * seed)["condition"] for seed in range(SEEDS)] for s in SECONDS}
        for name, way in ways.items()
    }
    designs = [pid.design_trajectory(robot, limits="joint", seed=seed) for seed in range(SEEDS)]
    found["physident"] = {
        "condition": [design.condition for design in designs],
        "seconds": [design.processor_seconds for design in designs],
    }
    return found


def ur10e(found: dict[str, Any], value: Any) -> float:
    """The median of a value over the tasks of the UR10e."""
    return float(np.median([value(one) for task, one in found.items() if task.startswith("ur10e")]))


def table(results: dict[str, Any]) -> str:
    """Errors, times, memory and impossible parameters on the UR10e; then the designed motions."""
    kept = json.loads((ROOT / "studies" / "benchmark" / "results.json").read_text(encoding="utf-8"))["entries"]
    rows = [joint_row("UR10e, held-out error [%], mean of 8 tasks", range(1, 7), 0)]
    for name in PROGRAMS:
        if name in kept:
            errors = [one["relative_percent"] for task, one in kept[name].items() if task.startswith("ur10e")]
            rows.append(joint_row(f"  {name}", np.mean(errors, axis=0), 1))
    found = results["arms"]
    rows += [
        "",
        f"{'UR10e, medians of 8 tasks':<26}"
        + "".join(f"{stage:>11}" for stage in (*STAGES, "all", "of plain", "memory")),
    ]
    rows.append(f"{'':<26}" + "".join(f"{unit:>11}" for unit in (*["[s]"] * (len(STAGES) + 1), "wls", "[MB]")))
    plain = ur10e(found["plain wls"], lambda one: working(one["seconds"]))
    for name in PROGRAMS:
        parts = [ur10e(found[name], lambda one, stage=stage: one["seconds"].get(stage, 0.0)) for stage in STAGES]
        work = ur10e(found[name], lambda one: working(one["seconds"]))
        memory = ur10e(found[name], lambda one: one["memory"])
        times = "".join(f"{part:11.2f}" if part else f"{'-':>11}" for part in (*parts, work))
        rows.append(f"  {name:<24}{times}{work / plain:11.1f}{memory:11.0f}")
    rows += ["all: without imports and without the prediction", ""]
    kinds = {"mass": "negative mass", "links": "impossible links", "viscous": "negative viscous", "dry": "negative dry"}
    rows.append(
        f"{'all 12 tasks, in total':<26}" + "".join(f"{head:>18}" for head in kinds.values()) + f"{'links in all':>18}"
    )
    for name in PROGRAMS:
        sums = [sum(len(one[kind]) for one in found[name].values()) for kind in kinds]
        count = sum(one["of"] for one in found[name].values())
        rows.append(f"  {name:<24}" + "".join(f"{one:18d}" for one in (*sums, count)))
    if "motions" in results:
        ours = results["motions"]["physident"]
        rows += [
            "",
            f"{'cond(Y_B) of a UR5 motion, 3 seeds':<36}" + "".join(f"{s:>12g} s of processor time" for s in SECONDS),
        ]
        for name, of in results["motions"].items():
            if name != "physident":
                cells = [f"{np.median(x):.1f} ({min(x):.1f} to {max(x):.1f})" for x in of.values()]
                rows.append(f"  {name:<34}" + "".join(f"{cell:>32}" for cell in cells))
        conditions = ours["condition"]
        rows.append(
            f"  physident, until it ends: {np.median(conditions):.1f} ({min(conditions):.1f} to {max(conditions):.1f}) in {np.median(ours['seconds']):.1f} s"
        )
    rows += ["", ", ".join(f"{name} {of}" for name, of in results["versions"].items())]
    return "\n".join(rows)


def working(seconds: dict[str, float]) -> float:
    """Processor time [s] from recordings to a model."""
    return sum(seconds.get(stage, 0.0) for stage in STAGES[1:])


def main() -> None:
    parts = {"arms": arms, "motions": motions}
    asked = sys.argv[1:] or list(parts)
    path = FOLDER / "results.json"
    results = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    for name in asked:
        if name != "table":
            results[name] = parts[name]()
    results["versions"] = {name: version(name) for name in VERSIONS}
    keep(FOLDER, results, table(results))


if __name__ == "__main__":
    main()
