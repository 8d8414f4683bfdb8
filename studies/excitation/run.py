"""How well and how fast is a motion designed, beside the thesis and beside other ways; and does it pay?

``run.py`` runs everything; ``run.py designed``, ``run.py others`` (7 minutes) and ``run.py pays`` renew a part.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import numpy as np

import physident as pid
from physident.excitation.task import task_of
from studies.excitation import others, pays
from studies.kept import keep  # sets its threads before numpy loads
from studies.thesis.halves import half
from studies.thesis.published import HOURS, trajectory

FOLDER = Path(__file__).parent
SEEDS = 5
GENETIC_SECONDS, DIFFERENCES_SECONDS, RANDOM_STARTS = 300.0, 120.0, 5


def designed() -> dict[str, Any]:
    """The thesis' problem for the whole arm and its halves, and the whole arm with all limits: five seeds each."""
    cases = {"whole": (pid.load_robot("ur5"), "joint"), "bse": (half("bse"), "joint"), "w": (half("w"), "joint")}
    cases["all_limits"] = (pid.load_robot("ur5"), "all")
    result: dict[str, Any] = {}
    for name, (robot, limits) in cases.items():
        found = [pid.design_trajectory(robot, limits=limits, seed=seed) for seed in range(SEEDS)]  # pyright: ignore[reportArgumentType]
        assert all(one.trajectory.at_rest and not one.trajectory.violations(robot) for one in found)
        result[name] = {
            "columns": found[0].columns,
            "condition": [one.condition for one in found],
            "seconds": [one.seconds for one in found],
            "processor_seconds": [one.processor_seconds for one in found],
            "least_relative_margin": min(one.margin / max(abs(one.allowed), 1e-9) for d in found for one in d.margins),
            "margins": {
                limit: min(one.margin for d in found for one in d.margins if one.limit == limit)
                for limit in dict.fromkeys(one.limit for one in found[0].margins)
            },
        }
    result["gradient_error"] = others.gradient_error(cases["whole"][0], SEEDS)
    return result


def published() -> dict[str, float]:
    """cond(Y_B) of the thesis' own tables on the same 1,000 instants."""
    motion, result = trajectory(), {}
    joints = {"whole": slice(0, 6), "bse": slice(0, 3), "w": slice(3, 6)}
    for name, own in joints.items():
        robot = pid.load_robot("ur5") if name == "whole" else half(name)
        states = motion.states(np.arange(1000) / 1000 / motion.base_frequency)
        Y = pid.make_effects(["rigid_body"])[0].regressor(
            robot, pid.Signals.of_states(*(x[:, own] for x in (states.q, states.v, states.a)))
        )
        result[name] = float(np.linalg.cond(Y[:, :, task_of(robot).chosen].reshape(-1, len(task_of(robot).chosen))))
    return result


def compared() -> dict[str, Any]:
    """The other ways, one after another."""
    robot = pid.load_robot("ur5")
    return {
        "random_starts": others.random_starts(robot, RANDOM_STARTS),
        "finite_differences": others.finite_differences(robot, DIFFERENCES_SECONDS),
        "genetic": others.genetic_alone(robot, GENETIC_SECONDS),
    }


def table(r: dict[str, Any]) -> str:
    """The study's table."""
    rows = [
        "cond(Y_B), first independent columns, unscaled       whole arm    first half    second half   processor time"
    ]
    d = r["designed"]
    rows.append(
        f"thesis, its tables recomputed                       {r['thesis']['whole']:9.1f} {r['thesis']['bse']:13.1f} {r['thesis']['w']:14.1f}   {sum(HOURS.values()):.0f} h"
    )
    medians = [np.median(d[name]["condition"]) for name in ("whole", "bse", "w")]
    times = [np.median(d[name]["processor_seconds"]) for name in ("whole", "bse", "w")]
    rows.append(
        f"designed, median of {SEEDS} seeds                         {medians[0]:9.1f} {medians[1]:13.1f} {medians[2]:14.1f}   {times[0]:.1f}, {times[1]:.1f}, {times[2]:.1f} s"
    )
    worst = [max(d[name]["condition"]) for name in ("whole", "bse", "w")]
    rows.append(
        f"designed, worst of them                             {worst[0]:9.1f} {worst[1]:13.1f} {worst[2]:14.1f}"
    )
    if "others" in r:
        o = r["others"]
        starts = o["random_starts"]
        rows += [
            f"IPOPT from a random start, median of {len(starts['condition'])}              {np.median(starts['condition']):9.1f}                               {np.median(starts['processor_seconds']):.1f} s",
            f"SLSQP, finite differences                           {o['finite_differences']['condition']:9.1f}                               {o['finite_differences']['processor_seconds']:.0f} s",
            f"genetic algorithm alone                             {o['genetic']['condition']:9.1f}                               {o['genetic']['processor_seconds']:.0f} s",
        ]
    every = d["all_limits"]
    rows += [
        "",
        f"all limits, whole arm: cond {np.median(every['condition']):.1f} (worst {max(every['condition']):.1f}) in {np.median(every['processor_seconds']):.1f} s of processor time (worst {max(every['processor_seconds']):.1f});",
        "least margin of five seeds: " + ", ".join(f"{name} {value:.3g}" for name, value in every["margins"].items()),
        f"exact gradients against fourth-order differences: {d['gradient_error']:.1e} relative, at worst",
    ]
    if "pays" in r:
        rows += [
            f"errors of {one['parameters']} parameters, random over designed motion, {name} limits: median {one['median_ratio']:.1f},"
            f" half of them {one['quartiles'][0]:.1f} to {one['quartiles'][1]:.1f}, designed better for {one['better']}"
            for name, one in r["pays"].items()
        ]
    return "\n".join(rows)


def main() -> None:
    parts = {"designed": designed, "others": compared, "pays": lambda: pays.study(pid.load_robot("ur5"))}
    asked = sys.argv[1:] or list(parts)
    path = FOLDER / "results.json"
    results = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    results["thesis"] = published()
    for name in asked:
        results[name] = parts[name]()
    keep(FOLDER, results, table(results))


if __name__ == "__main__":
    main()
