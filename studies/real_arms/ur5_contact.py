"""(d) A UR5 that a hand pushes now and then, and the same motion without: contact, its intervals, and none in the twin."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from asking import DATA, HERE, UR5, ask, brief, diagnose, named, paths, shown
from twins import difference, pair, pushes

import physident as pid
from physident.graphics.style import JOINTS, effect_colour, figure, save

FREE = ("move4_fast.csv.gz", "move5.csv.gz", "move6.csv.gz", "move8.csv.gz", "move9.csv.gz")


def study(work: Path) -> tuple[dict[str, Any], list[str]]:
    """Results and printed rows."""
    model = work / "ur5_free.json"
    ask("identify", *paths("ur5", *FREE), "--robot", "ur5", *UR5, "--out", model)
    pushed = diagnose(work, "ur5_pushed", model, paths("ur5", "move7_contact.csv.gz"))
    clean = diagnose(work, "ur5_clean", model, paths("ur5", "move7.csv.gz"))
    time, apart, _ = difference(*pair(str(DATA / "ur5")), pid.Filter(8.0))
    truth = pushes(time, apart)
    found = sorted(tuple(i) for f in pushed["findings"] for i in f["intervals"])
    met = [any(_overlap(one, other) for other in found) for one in truth]
    wrong = [one for one in found if not any(_overlap(one, other) for other in truth)]
    covered = sum(min(a[1], b[1]) - max(a[0], b[0]) for a in found for b in truth if _overlap(a, b))
    long = sum(b - a for a, b in found)
    rows = [
        "$ physident identify move4_fast move5 move6 move8 move9 --robot ur5 --cutoff 8 ...",
        "$ physident diagnose --model m.json move7_contact.csv.gz", *shown(pushed), "",
        "$ physident diagnose --model m.json move7.csv.gz    # the same motion, untouched", *shown(clean), "",
        "when the twins differ by more than 6 N m on two joints: " + _spans(truth),
        "contact found:                                          " + _spans(found),
        f"pushes met: {sum(met)} of {len(met)}; contacts where there was no push: {len(wrong)};"
        f" {long:.1f} s called contact, of which {covered:.1f} s are pushes",
        f"in the untouched twin: {named(clean)}",
    ]  # fmt: skip
    results = {
        "pushed": brief(pushed), "clean": brief(clean), "pushes": truth, "contacts": found, "met": sum(met),
        "wrong": len(wrong), "called_s": long, "covered_s": covered,
    }  # fmt: skip
    _draw(time, apart, truth, found, HERE / "ur5_contact.png")
    return results, rows


def _overlap(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return min(a[1], b[1]) > max(a[0], b[0])


def _spans(spans: Any) -> str:
    return ", ".join(f"{a:.1f} to {b:.1f} s" for a, b in spans) or "none"


def _draw(time: Any, apart: Any, truth: Any, found: Any, path: Path) -> None:
    fig, ((ax,),) = figure(1, 1, (9.0, 3.2))
    for j in range(4):
        ax.plot(time, apart[:, j], color=JOINTS[j], label=f"joint {j + 1}")
    top = float(np.abs(apart).max())
    for k, (a, b) in enumerate(found):
        ax.axvspan(a, b, color=effect_colour("contact"), alpha=0.15, label="contact, found" if k == 0 else None)
    for k, (a, b) in enumerate(truth):
        ax.plot([a, b], [-top, -top], "k", linewidth=5, solid_capstyle="butt", label="twins differ" if k == 0 else None)
    ax.set(xlabel="time [s]", ylabel="pushed less untouched [N m]", ylim=(-1.2 * top, 1.5 * top))
    ax.legend(ncols=6, loc="upper center", fontsize=8)
    save(fig, path)
