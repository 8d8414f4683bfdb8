"""(a) What does the default model of a UR10e miss? Eight runs of February; each left out once; a run of January unseen."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from asking import HERE, UR10E, ask, brief, diagnose, february, named, paths, percent, shown
from kept import UR10E_COLUMNS, UR10E_GAINS, joint_row
from remainder import explained
from reversals import reversals

import physident as pid
from physident.graphics.style import JOINTS, figure, save

ALLOWED = (6.5, 2.6, 2.4, 7.4, 10.7, 9.2)  # % on left-out runs


def study(work: Path) -> tuple[dict[str, Any], list[str]]:
    """Results and printed rows."""
    model, extended, found = february(work)
    runs, robot = paths("ur10e", "ur-20_02_*.csv"), paths("ur10e", "ur10e.urdf")[0]
    folds = [_left_out(work, robot, runs, k) for k in range(len(runs))]
    mean = {key: np.mean([f[key] for f in folds], axis=0).tolist() for key in ("before", "after", "physical")}
    (january,) = paths("ur10e", "ur-20_01_31-unload.csv")
    target = work / "january.json"
    ask("compare", "--model", model, "--model", extended, "--on", january, "--json", target)
    unseen = json.loads(target.read_text(encoding="utf-8"))
    loaded = pid.load_recordings([str(r) for r in runs], UR10E_COLUMNS, UR10E_GAINS)
    estimate = pid.load_estimate(extended)
    turns, rest = reversals(estimate, loaded), explained(pid.load_estimate(model), estimate, loaded)
    results = {
        "diagnosis": brief(found), "left_out": folds, "left_out_mean": mean, "allowed": ALLOWED,
        "january": {k: unseen[k]["relative_percent_all"] for k in ("before", "after")},
        "reversals": turns["table"], "remainder": rest,
    }  # fmt: skip
    rows = [
        "$ physident identify ur-20_02_*.csv --robot ur10e.urdf --columns ... --drive-gains ... --out m.json",
        "$ physident diagnose --model m.json ur-20_02_*.csv --out extended.json",
        *shown(found), "",
        "each run left out once, diagnosed without it and scored on it (--holdout): relative error [%], mean of eight",
        joint_row("joint", range(1, 7), 0),
        joint_row("default model", mean["before"], 1),
        joint_row("what diagnosis made of it", mean["after"], 1),
        joint_row("the same effects, --method physical", mean["physical"], 1),
        joint_row("asked for", ALLOWED, 1),
        *(f"  without {Path(runs[k].name).stem:<28} {percent(f['after'])}   {f['named']}" for k, f in enumerate(folds)),
        "", "a run of 31 January, which nothing saw: relative error [%]",
        joint_row("default model", results["january"]["before"], 1),
        joint_row("extended model", results["january"]["after"], 1),
        "", *turns["rows"], "", *_remainder_rows(rest),
    ]  # fmt: skip
    _draw(mean, turns, HERE / "ur10e_structure.png")
    return results, rows


def _left_out(work: Path, robot: Path, runs: list[Path], out: int) -> dict[str, Any]:
    """Diagnosis of all runs but one, scored on that one; and the same effects as a physical estimate."""
    train, model = [r for k, r in enumerate(runs) if k != out], work / f"without_{out}.json"
    ask("identify", *train, "--robot", robot, *UR10E, "--out", model)
    found = diagnose(work, f"without_{out}_diagnosis", model, train, "--holdout", runs[out])
    effects = pid.load_estimate(work / f"without_{out}_diagnosis_extended.json").model
    loaded = pid.load_recordings([str(r) for r in train], UR10E_COLUMNS, UR10E_GAINS)
    bodies = pid.identify(effects.robot, loaded, effects.effects, pid.Physical(resamples=0))
    unseen = pid.load_recordings([str(runs[out])], UR10E_COLUMNS, UR10E_GAINS)
    return {
        "run": runs[out].name,
        "named": named(found),
        "before": found["score"]["before"]["relative_percent_all"],
        "after": found["score"]["after"]["relative_percent_all"],
        "physical": pid.validate(bodies, unseen).relative_all.tolist(),
        "violated": list(bodies.violations),
        "placebos_passed": sum(p["passed"] for p in found["placebos"]),
    }


def _remainder_rows(rest: dict[str, Any]) -> list[str]:
    return [
        "what remains of the torque, and what it is",
        joint_row("joint", range(1, 7), 0),
        joint_row("power below 0.2 Hz, default model [%]", rest["slow_before"], 0),
        joint_row("power below 0.2 Hz, extended model [%]", rest["slow_after"], 0),
        joint_row("  with a friction of each run's own [%]", rest["slow_own_friction"], 0),
        joint_row("explained by a friction of each run [%]", rest["own_friction"], 0),
        joint_row("power while the joint itself stands still [%]", rest["standing"], 0),
        joint_row("time that it stands still [%]", rest["standing_time"], 0),
        joint_row("dry friction 5-6 February [N m]", rest["dry_early"], 2),
        joint_row("dry friction 10-12 February [N m]", rest["dry_late"], 2),
    ]


def _draw(mean: dict[str, Any], turns: dict[str, Any], path: Path) -> None:
    fig, ((bars, by_time, by_travel),) = figure(1, 3, (4.0, 3.0))
    at = np.arange(6)
    bars.bar(at - 0.2, mean["before"], 0.4, color="#BBBBBB", label="default model")
    bars.bar(at + 0.2, mean["after"], 0.4, color=JOINTS[0], label="extended by diagnosis")
    bars.plot(at, ALLOWED, "k_", markersize=16, label="asked for")
    bars.set_xticks(at, [str(j + 1) for j in at])
    bars.set(xlabel="joint", ylabel="error on left-out runs [%]")
    bars.legend()
    for curve, colour in zip(turns["curves"], JOINTS, strict=False):
        label = f"{curve['acceleration']:.2g} rad/s²"
        by_time.plot(1e3 * curve["time"], curve["friction"], color=colour, label=label)
        by_travel.plot(1e3 * curve["travel"], curve["friction"], color=colour, label=label)
    by_time.set(xlabel="time since reversal [ms]", ylabel="dry friction of joint 6 [N m]")
    by_travel.set(xlabel="travel since reversal [mrad]", xlim=(0, 3))
    by_travel.legend(title="at reversal")
    save(fig, path)
