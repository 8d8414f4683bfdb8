"""(b) A UR10e with a load of known mass, one of unknown mass, and with none: what differs from the February runs?"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from asking import DATA, HERE, UR10E, ask, brief, diagnose, february, named, parameter, paths, shown

from physident.graphics.style import JOINTS, effect_colour, figure, save

KNOWN = 2.6  # kg, by the recording's name
RUNS = {
    "2.6 kg, 13 January": "ur-20_01_13-load_2600.csv",
    "unknown load, 31 January": "ur-20_01_31-load.csv",
    "no load, 31 January": "ur-20_01_31-unload.csv",
}


def study(work: Path) -> tuple[dict[str, Any], list[str]]:
    """Results and printed rows."""
    default, extended, _ = february(work)
    answers = {label: diagnose(work, name, extended, paths("ur10e", name)) for label, name in RUNS.items()}
    plain = {label: diagnose(work, f"default_{name}", default, paths("ur10e", name)) for label, name in RUNS.items()}
    masses = {label: parameter(found, "payload", "mass") for label, found in answers.items()}
    rows = []
    for label, found in answers.items():
        rows += [f"$ physident diagnose --model extended.json {RUNS[label]}    # {label}", *shown(found), ""]
    known, unknown = (masses[label] for label in list(RUNS)[:2])
    scale = None
    if known is not None and unknown is not None:
        scale = KNOWN / known["value"]
        low, high = (KNOWN / end for end in reversed(known["interval95"]))
        rows += [
            f"drive gains: the load of {KNOWN} kg comes out as {known['value']:.2f} kg; were the gains alone to blame, their scale"
            f" would be {scale:.3f} [{low:.3f}, {high:.3f}]",
            f"the other load weighs {unknown['value']:.2f} kg by the given gains, {scale * unknown['value']:.2f} kg by that scale",
            "",
        ]
    rows.append("asked of the default model instead, in which friction by load is missing:")
    rows += [f"  {label:<26} {named(found)}" for label, found in plain.items()]
    twin = _compared(work)
    mass = parameter(twin, "payload", "mass")
    rows += [
        "asked of the default model fitted to the run without load of that day as well, which is of the same motion:",
        f"  unknown load, 31 January   {named(twin)}",
    ]
    if mass is not None:
        low, high = mass["interval95"]
        rows.append(f"  its mass: {mass['value']:.2f} kg [{low:.2f}, {high:.2f}]")
    results = {
        "compared": brief(twin),
        "diagnoses": {label: brief(found) for label, found in answers.items()},
        "default_model": {label: brief(found) for label, found in plain.items()},
        "mass": masses, "known_kg": KNOWN, "gain_scale": scale,
    }  # fmt: skip
    _draw(answers, masses, HERE / "ur10e_load.png")
    return results, rows


def _compared(work: Path) -> dict[str, Any]:
    """The run with the unknown load, beside the one without that repeats its motion."""
    model, runs = work / "ur10e_unloaded.json", paths("ur10e", "ur-20_02_*.csv", RUNS["no load, 31 January"])
    ask("identify", *runs, "--robot", DATA / "ur10e" / "ur10e.urdf", *UR10E, "--out", model)
    return diagnose(work, "compared", model, paths("ur10e", RUNS["unknown load, 31 January"]))


def _draw(answers: dict[str, Any], masses: dict[str, Any], path: Path) -> None:
    fig, ((errors, mass),) = figure(1, 2, (4.5, 3.0))
    at = np.arange(6)
    for k, (label, found) in enumerate(answers.items()):
        for side, shade in (("before", 0.35), ("after", 1.0)):
            values = found["score"][side]["relative_percent_all"]
            errors.plot(at, values, "o-", color=JOINTS[k], alpha=shade, label=f"{label}, {side}")
    errors.set_xticks(at, [str(j + 1) for j in at])
    errors.set(xlabel="joint", ylabel="error on left-out rows [%]", yscale="log", ylim=(1, 900))
    errors.legend(fontsize=7, ncols=2)
    for k, value in enumerate(masses.values()):
        if value is not None:
            low, high = value["interval95"]
            mass.plot([k, k], [low, high], color=effect_colour("payload"), linewidth=3)
            mass.plot(k, value["value"], "o", color=effect_colour("payload"))
    mass.axhline(KNOWN, color="k", linestyle=":", label="known: 2.6 kg")
    mass.set_xticks(range(len(masses)), [label.replace(", ", "\n") for label in masses])
    mass.set(ylabel="mass found, with 95 % interval [kg]", ylim=(0, 3.5), xlim=(-0.5, 2.5))
    mass.text(2, 0.1, "none found", ha="center") if masses["no load, 31 January"] is None else None
    mass.legend(loc="lower left")
    save(fig, path)
