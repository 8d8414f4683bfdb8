# fast: simulated UR5, under five minutes of processor time
"""The thesis that physident grew from, reproduced and surpassed: models A-D, base parameters, trajectories, calibration."""

from __future__ import annotations

import json
import sys
import warnings
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import physident as pid
from studies.kept import keep
from studies.thesis import bases, coupling, coverage, dh_calibration, diagnosed, figures, models, trajectories
from studies.thesis.published import COST, HOURS, trajectory
from studies.thesis.tables import blocks, fill, summary

FOLDER = Path(__file__).parent
VALIDATION_SEED = 7


def motions(robot: pid.Robot) -> dict[str, pid.Trajectory]:
    """The thesis' trajectory, ours (made by ``design.py``), and a random one that nothing is identified on."""
    designed = pid.load_trajectory(FOLDER / "designed.json")
    assert isinstance(designed, pid.Trajectory)
    second = pid.random_trajectory(robot, VALIDATION_SEED, base_frequency=0.15, duration=20.0)
    return {"thesis": trajectory(), "designed": designed, "validation": second}


def base_parameters(robot: pid.Robot) -> tuple[dict[str, Any], dict[str, list[str]]]:
    """How many there are, and the thesis' lists beside what its columns stand for."""
    whole = pid.find_base_parameters(robot, pid.make_effects(["rigid_body"]))
    data: dict[str, Any] = {"whole": whole.r}
    rows = {}
    for name in ("bse", "w"):
        found = bases.compare(name)
        data |= {name: found.ours.r, f"{name}_largest_angle_rad": found.angle}
        data[f"{name}_as_printed_rank"] = bases.printed_rank(name)
        rows[f"list {name}"] = bases.table(name, found)
    return data, rows


def main() -> None:
    warnings.simplefilter("ignore", pid.PhysidentWarning)  # 20 s hold few independent samples: coverage is measured
    robot = pid.load_robot("ur5")
    ways = motions(robot)
    counts, lists = base_parameters(robot)
    results: dict[str, Any] = {"base_parameters": counts}
    for model in "abcd":
        found = models.compare(model, robot, ways)
        results[f"model_{model}"] = models.results(found, robot)
        figures.torques(found, models.best(found))
    for model in "bd":
        results[f"model_{model}"]["diagnosis"] = diagnosed.of_model(model, robot, ways)
    results["model_b"]["diagnosis_of_the_reference"] = diagnosed.of_reference("b", robot, ways)
    results["coverage"] = {
        model: {name: coverage.coverage(model, robot, ways[name]) for name in ("thesis", "designed")} for model in "cd"
    }
    results["coupling"] = coupling.cost(robot, ways["designed"], ways["validation"])
    results["trajectories"] = {name: trajectories.properties(robot, motion) for name, motion in ways.items()}
    results["trajectories"]["reported"] = {"cond": COST, "hours": HOURS}
    results["trajectories"]["ours"] = json.loads((FOLDER / "design.json").read_text(encoding="utf-8"))
    results["dh_calibration"] = dh_calibration.cost(robot, ways["designed"], ways["validation"])
    results["joint_zero_offset"] = diagnosed.of_zero_offset(robot, ways)
    figures.trajectories(robot, ways)
    figures.manipulability(robot, ways)
    tables = blocks(results) | lists
    for name, rows in tables.items():
        print("\n".join([f"-- {name}", *rows, ""]))
    fill(FOLDER / "README.md", tables)
    keep(FOLDER, results, "\n".join(summary(results)))


if __name__ == "__main__":
    main()
