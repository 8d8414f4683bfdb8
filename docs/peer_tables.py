"""What README and docs/measured.md say of other tools, from the kept results of studies/benchmark, peers and replay."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
NAMES = {
    "physident wls": "the default model",
    "physident diagnosed": "extended by its diagnosis",
    "figaroh wls": "figaroh",
    "plain wls": "a plain script with pinocchio",
}


def results(study: str) -> dict[str, Any]:
    """What a study kept."""
    return json.loads((ROOT / "studies" / study / "results.json").read_text(encoding="utf-8"))


def errors(entry: str, arm: str) -> Any:
    """Mean held-out error [%] of each joint over the benchmark's tasks of an arm."""
    of = results("benchmark")["entries"][entry]
    return np.mean([one["relative_percent"] for task, one in of.items() if task.split("_")[0] == arm], axis=0)


def middle(entry: str, value: Any) -> float:
    """The median of a value over the tasks of the UR10e."""
    of = results("peers")["arms"][entry]
    return float(np.median([value(one) for task, one in of.items() if task.startswith("ur10e")]))


def seconds(entry: str) -> float:
    """Median processor time [s] from the recordings of a UR10e to its model."""
    return middle(
        entry, lambda one: sum(t for stage, t in one["seconds"].items() if stage not in ("imports", "predict"))
    )


def figures(values: Any) -> str:
    """Errors of all joints."""
    return " ".join(f"{value:.1f}" for value in values)


def compared() -> str:
    """Six lines for README."""
    version = results("peers")["versions"]["figaroh"]
    ours = errors("physident wls", "ur5")
    fewer = [(errors(entry, "ur5") < ours).sum() for entry in ("plain wls", "figaroh wls")]
    kept, e = results("peers")["motions"], results("replay")["e"]
    design = kept["physident"]
    others = {way: np.median(of[max(of, key=float)]) for way, of in kept.items() if way != "physident"}
    longest = max(map(float, kept["SLSQP, finite differences"]))
    sysid = [one for name, one in e.items() if name.startswith("mujoco.sysid")]
    parts = ("armature", "damping", "frictionloss")
    mine, theirs = [e["physident"][part] for part in parts], [min(one[part] for one in sysid) for part in parts]
    return "\n".join(
        [
            "- Error on left-out runs of a real UR10e, joints 1 to 6, rests included: "
            + "; ".join(f"{name} {figures(errors(entry, 'ur10e'))} %" for entry, name in NAMES.items()) + ".",
            f"- On a real UR5 the plain script errs less than the default model on {fewer[0]} of {len(ours)} joints, figaroh on {fewer[1]}.",
            f"- From seven runs to a model: plain script {seconds('plain wls'):.1f} s, figaroh {version} {seconds('figaroh wls'):.1f} s, physident"
            f" {seconds('physident wls'):.1f} s, with its diagnosis {seconds('physident diagnosed'):.0f} s of processor time; memory"
            f" {memory('plain wls')}, {memory('figaroh wls')}, {memory('physident wls')} and {memory('physident diagnosed')} MB.",
            f"- Parameters of a simulated arm's joints: {min(mine):.1f} to {max(mine):.1f} % off in {e['physident']['s']:.1f} s; `mujoco.sysid`, which needs no"
            f" accelerations and takes any sensor, {min(theirs):.1f} to {max(theirs):.1f} % in {min(one['s'] for one in sysid):.0f} s and more.",
            f"- A designed motion: condition number {np.median(design['condition']):.1f} in {np.median(design['seconds']):.0f} s of processor time; "
            + ", ".join(f"{way} {value:.1f}" for way, value in others.items()) + f", each in {longest:.0f} s.",
            "- [What each tool can do](studies/peers/README.md), and where others do better: floating bases, contact, any sensor, geometric calibration.",
        ]
    )  # fmt: skip


def memory(entry: str) -> str:
    """Median of the largest memory [MB] on the UR10e's tasks."""
    return f"{middle(entry, lambda one: one['memory']):.0f}"


def beside_others() -> str:
    """A table of held-out errors for docs/measured.md, each arm and tool."""
    rows = ["| arm | tool | error [%], joints 1 to n |", "|---|---|---|"]
    for arm in ("ur10e", "ur5", "ur10", "panda"):
        rows += [f"| {arm} | {name} | {figures(errors(entry, arm))} |" for entry, name in NAMES.items()]
    return "\n".join(rows)
