"""(c) An industrial TX40 whose wrist is coupled by gears: is the coupling found, and does it predict the unseen half?"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from asking import DATA, HERE, ask, brief, diagnose, named, shown
from kept import joint_row

from physident.graphics.style import JOINTS, figure, save

RATE = 5000.0  # Hz
RATIOS = (32.0, 32.0, 45.0, -48.0, 45.0, 32.0)
COUPLING = 32.0  # of motor 6 with joint 5
ALLOWED_IN, ALLOWED_UNSEEN = (11.0, 10.0), 27.0  # % of joints 5 and 6 in sample, of joint 5 unseen


def study(work: Path) -> tuple[dict[str, Any], list[str]]:
    """Results and printed rows."""
    files, robot = recordings(work), DATA / "tx40" / "tx40_mdh_modified.urdf"
    models = {part: work / f"tx40_{part}.json" for part in ("whole", "first")}
    for part, model in models.items():
        ask("identify", files[part], "--robot", robot, "--out", model)
    whole = diagnose(work, "tx40_whole_answer", models["whole"], [files["whole"]])
    half = diagnose(work, "tx40_half_answer", models["first"], [files["first"]], "--holdout", files["second"])
    inside = {
        label: _inside(work, model, files["whole"])
        for label, model in (("default", models["whole"]), ("extended", work / "tx40_whole_answer_extended.json"))
    }
    unseen = {side: half["score"][side]["relative_percent_all"] for side in ("before", "after")}
    rows = [
        "$ physident identify tx40.csv --robot tx40.urdf --out m.json; physident diagnose --model m.json tx40.csv",
        *shown(whole), "",
        "$ physident identify first_half.csv ...; physident diagnose --model m.json first_half.csv --holdout second_half.csv",
        *shown(half), "",
        "relative error [%], cutoff 5 Hz", joint_row("joint", range(1, 7), 0),
        *(joint_row(f"in sample, {label} model", values, 1) for label, values in inside.items()),
        joint_row("second half, unseen, default model", unseen["before"], 1),
        joint_row("second half, unseen, extended model", unseen["after"], 1),
        f"asked for: joints 5 and 6 about {ALLOWED_IN[0]:g} and {ALLOWED_IN[1]:g} in sample, joint 5 at most"
        f" {ALLOWED_UNSEEN:g} unseen; found on half the data: {named(half)}",
    ]  # fmt: skip
    results = {"whole": brief(whole), "half": brief(half), "inside": inside, "unseen": unseen}
    _draw(inside, unseen, HERE / "tx40_coupling.png")
    return results, rows


def recordings(work: Path) -> dict[str, Path]:
    """The recording on the joints' side of its gears, q = R^-1 q_m and tau = R^T tau_m, whole and in halves."""
    folder = DATA / "tx40"
    motor, torque = (
        np.genfromtxt(folder / f"{n}_data.csv.gz", delimiter=",", skip_header=1) for n in ("pos_read", "curr")
    )
    R = np.diag(RATIOS)
    R[5, 4] = COUPLING
    q = np.linalg.solve(R, motor.T).T + np.array([0, -np.pi / 2, np.pi / 2, 0, 0, 0])
    table = np.column_stack([np.arange(len(q)) / RATE, q, torque @ R])
    names = ["time", *(f"{x}_{j}" for x in ("q", "tau") for j in range(1, 7))]
    half, files = len(q) // 2, {}
    for part, rows in (("whole", slice(None)), ("first", slice(half)), ("second", slice(half, None))):
        files[part] = work / f"tx40_{part}_half.csv"
        np.savetxt(files[part], table[rows], delimiter=",", header=",".join(names), comments="", fmt="%.9g")
    return files


def _inside(work: Path, model: Path, recording: Path) -> list[float]:
    target = work / "inside.json"
    ask("validate", "--model", model, recording, "--include-fitted", "--json", target)
    return json.loads(target.read_text(encoding="utf-8"))["relative_percent_all"]


def _draw(inside: dict[str, list[float]], unseen: dict[str, list[float]], path: Path) -> None:
    fig, (axes,) = figure(1, 2, (4.5, 3.0))
    cases = (
        ("in sample", inside["default"], inside["extended"]),
        ("second half, unseen", unseen["before"], unseen["after"]),
    )
    at = np.arange(6)
    for ax, (title, before, after) in zip(axes, cases, strict=True):
        ax.bar(at - 0.2, before, 0.4, color="#BBBBBB", label="default model")
        ax.bar(at + 0.2, after, 0.4, color=JOINTS[0], label="extended by diagnosis")
        ax.set_xticks(at, [str(j + 1) for j in at])
        ax.set(title=title, xlabel="joint", ylabel="relative error [%]")
    axes[0].legend()
    save(fig, path)
