"""What has changed on a real UR10e between January and February, recording by recording?"""

from __future__ import annotations

import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import numpy as np
from kept import UR10E_COLUMNS, UR10E_GAINS, keep, need_data

import physident as pid
from physident.estimation.estimate import Estimate
from physident.fleet.candidates import words_of
from physident.fleet.changes import Change, changes_in
from physident.fleet.drift.alarms import MORE
from physident.fleet.work import Reading, make_baseline

BASELINE = 4  # recordings, the first four of February
JANUARY = ("ur-20_01_13-load_2600", "ur-20_01_31-load", "ur-20_01_31-unload")
SHOWN = 3  # causes of a recording


def main() -> None:
    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    february = sorted(data.glob("ur-20_02_*.csv"))
    reading = Reading(columns=UR10E_COLUMNS, drive_gains=UR10E_GAINS)
    baseline = make_baseline(robot, [str(path) for path in february[:BASELINE]], BASELINE, reading)
    if not isinstance(baseline, Estimate):
        sys.exit(baseline)
    results: dict[str, Any] = {"effects": [effect.name for effect in baseline.model.effects], "recordings": {}}
    for path in [*(data / f"{name}.csv" for name in JANUARY), *february]:
        recording = pid.load_recording(path, UR10E_COLUMNS, UR10E_GAINS)
        results["recordings"][path.stem] = told(changes_in(baseline, recording), path in february[:BASELINE])
    keep(Path(__file__).parent, results, table(results))


def told(changes: list[Change], fitted: bool) -> dict[str, Any]:
    """The causes that explain a recording best, alone, and how large its changes are beside their standard errors."""
    noise = float(np.median([one.std * np.sqrt(one.information) for one in changes]))
    causes: dict[tuple[str, int], list[Change]] = defaultdict(list)
    for one in changes:
        causes[one.candidate.effect, one.candidate.joint].append(one)
    gains = {key: gain(group, noise) for key, group in causes.items()}
    best = sorted(gains, key=lambda key: -gains[key])[:SHOWN]
    mass = next(one for one in changes if one.parameter == "payload_mass")
    z = np.array([one.change / one.std for one in changes])
    return {
        "fitted": fitted, "causes": [[words_of(*key), gains[key]] for key in best],
        "payload_mass_kg": [mass.change, mass.high - mass.value], "median_z": float(np.median(np.abs(z))),
        "friction": {
            one.parameter: [one.change, one.high - one.value] for one in changes if one.candidate.effect == "friction"
        },
    }  # fmt: skip


def gain(group: list[Change], noise: float) -> float:
    """What a cause explains of a recording, in squares of the noise, as ``drift`` counts it."""
    change, M = np.array([one.change for one in group]), np.array([one.coupling for one in group])
    return float(change @ M @ change) / noise**2 - MORE * (len(group) - 1)


def table(results: dict[str, Any]) -> str:
    rows = [
        f"{'recording':<28}{'payload kg':>16}{'median |z|':>12}   what explains it best alone (squares of the noise)",
    ]
    for name, one in results["recordings"].items():
        mass = "{:.2f} ± {:.2f}".format(*one["payload_mass_kg"])
        causes = "; ".join(f"{words} {gains:.0f}" for words, gains in one["causes"][:2])
        rows.append(f"{name + ('*' if one['fitted'] else ''):<28}{mass:>16}{one['median_z']:>12.1f}   {causes}")
    rows += ["", "change of the friction of each joint [%], 95 % interval"]
    for name, one in results["recordings"].items():
        cells = "".join(f"{f'{100 * c:+.0f} ± {100 * h:.0f}':>11}" for c, h in one["friction"].values())
        rows.append(f"{name + ('*' if one['fitted'] else ''):<28}{cells}")
    rows.append("* one of the four recordings of the baseline")
    return "\n".join(rows)


if __name__ == "__main__":
    main()
