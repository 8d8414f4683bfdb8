"""(e) A simulation of the UR5 from its published table, without friction: what real movements show it gets wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from asking import DATA, HERE, UR5, UR5_GAINS, ask, brief, named, paths, shown
from kept import joint_row

import physident as pid
from physident.estimation.estimate import as_estimate
from physident.graphics.style import JOINTS, figure, save

SHOWN = ("move6.csv.gz", "move5.csv.gz", "move9.csv.gz")
UNSEEN = ("move8", "move4_fast")


def study(work: Path) -> tuple[dict[str, Any], list[str]]:
    """Results and printed rows."""
    import json

    target, extended, fitted = work / "nominal.json", work / "nominal_extended.json", work / "ur5_fitted.json"
    text = ask("diagnose", "--robot", "ur5", *paths("ur5", *SHOWN), *UR5, "--json", target, "--out", extended)
    found = json.loads(target.read_text(encoding="utf-8")) | {"text": text}
    ask("identify", *paths("ur5", *SHOWN), "--robot", "ur5", *UR5, "--out", fitted)
    bare = as_estimate(pid.Model.nominal(pid.load_robot("ur5"), ["rigid_body"]), pid.Filter(8.0))
    models = {
        "the table alone": bare,
        "extended by diagnosis": pid.load_estimate(extended),
        "default model, identified": pid.load_estimate(fitted),
    }
    unseen = {name: pid.load_recording(DATA / "ur5" / f"{name}.csv.gz", drive_gains=UR5_GAINS) for name in UNSEEN}
    errors = {
        name: {label: pid.validate(model, [run]).relative_all.tolist() for label, model in models.items()}
        for name, run in unseen.items()
    }
    shown_runs = pid.load_recordings([str(p) for p in paths("ur5", *SHOWN)], drive_gains=UR5_GAINS)
    speeds = {"diagnosed": _fastest(shown_runs)} | {name: _fastest([run]) for name, run in unseen.items()}
    rows = [
        "$ physident diagnose --robot ur5 move6.csv.gz move5.csv.gz move9.csv.gz --drive-gains ... --cutoff 8", *shown(found), "",
        "relative error [%], cutoff 8 Hz", joint_row("joint", range(1, 7), 0),
    ]  # fmt: skip
    for name, each in errors.items():
        rows += [joint_row(f"{name}: {label}", values, 1) for label, values in each.items()]
    rows += ["fastest [rad/s]", *(joint_row(f"  {name}", values) for name, values in speeds.items())]
    results = {"diagnosis": brief(found), "named": named(found), "errors": errors, "fastest": speeds}
    _draw(errors, HERE / "ur5_nominal.png")
    return results, rows


def _fastest(recordings: list[pid.Recording]) -> list[float]:
    signals = [pid.prepare(r, pid.Filter(8.0)) for r in recordings]
    return np.max([np.abs(s.v).max(axis=0) for s in signals], axis=0).tolist()


def _draw(errors: dict[str, dict[str, list[float]]], path: Path) -> None:
    fig, (axes,) = figure(1, 2, (4.5, 3.0), sharey=True)
    at = np.arange(6)
    for ax, (name, each) in zip(axes, errors.items(), strict=True):
        for k, (label, values) in enumerate(each.items()):
            ax.bar(at + 0.27 * (k - 1), values, 0.27, color=("#BBBBBB", JOINTS[0], JOINTS[1])[k], label=label)
        ax.set_xticks(at, [str(j + 1) for j in at])
        ax.set(title=f"{name}, unseen", xlabel="joint", ylabel="relative error [%]", ylim=(0, 150))
    axes[0].legend()
    save(fig, path)
