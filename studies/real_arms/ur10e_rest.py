"""(f) A UR10e that stands still in three poses, and a UR5 that stands twice in the same one: what stiction does."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from asking import DATA, HERE, ask, february, paths
from kept import joint_row
from twins import WINDOW, difference, pair, pushes

import physident as pid
from physident.graphics.style import JOINTS, figure, save

AFTER = 1.0  # s beside a push, in which the arm has not settled


def study(work: Path) -> tuple[dict[str, Any], list[str]]:
    """Results and printed rows."""
    _, extended, _ = february(work)
    target = work / "rest.json"
    text = ask("diagnose", "--model", extended, *paths("ur10e", "ur-20_01_17-p?.csv"), "--json", target)
    found = json.loads(target.read_text(encoding="utf-8"))
    for pose in found["poses"]:
        pose["source"] = Path(pose["source"]).name
    error = [
        [100 * abs(h) / abs(m) for h, m in zip(pose["held"], pose["measured"], strict=True)] for pose in found["poses"]
    ]
    time, apart, moving = difference(*pair(str(DATA / "ur5")), pid.Filter(8.0))
    still = ~moving & (time > WINDOW)
    for start, end in pushes(time, apart):
        still &= (time < start - AFTER) | (time > end + AFTER)
    twice = np.abs(apart[still]).max(axis=0).tolist()
    rows = [
        "$ physident diagnose --model extended.json ur-20_01_17-p?.csv", *text.splitlines(), "",
        "error of the torque prediction at rest, relative [%]", joint_row("joint", range(1, 7), 0),
        *(joint_row(pose["source"], values, 0) for pose, values in zip(found["poses"], error, strict=True)), "",
        "a UR5 standing in the same poses twice (move7, move7_contact): largest difference of torque, pushes left out [N m]",
        joint_row("joint", range(1, 7), 0), joint_row(f"{still.sum() / 125:.1f} s at rest", twice, 1),
    ]  # fmt: skip
    _draw(found, HERE / "ur10e_rest.png")
    return {"at_rest": found, "relative_percent": error, "same_pose_twice": twice}, rows


def _draw(found: dict[str, Any], path: Path) -> None:
    fig, ((ax,),) = figure(1, 1, (6.0, 3.0))
    at = np.arange(6)
    friction = np.max([pose["friction"] for pose in found["poses"]], axis=0)
    ax.bar(at, 2 * friction, 0.8, bottom=-friction, color="#DDDDDD", label="what friction can hold")
    for k, pose in enumerate(found["poses"]):
        ax.plot(at + 0.15 * (k - 1), pose["held"], "o", color=JOINTS[k], label=pose["source"])
    ax.set_xticks(at, [str(j + 1) for j in at])
    ax.set(xlabel="joint", ylabel="measured less gravity [N m]", yscale="symlog", ylim=(-40, 400))
    ax.legend(fontsize=8, ncols=2, loc="upper right")
    save(fig, path)
