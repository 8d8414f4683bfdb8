# fast: simulated arms, real UR10e and UR5 recordings, one and a half minutes
"""What is one ampere worth? Drive gains of a UR10e from a load of 2.6 kg, and two contradicting sets of a UR5."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from brackets import GAIN_SETS, ur5_brackets
from kept import UR10E_COLUMNS, UR10E_GAINS, joint_row, keep, need_data
from simulated import simulated_gains

import physident as pid
from physident.estimation.uncertainty import t_quantile
from physident.graphics.style import AS_IT_WAS, EXTENDED, MEASURED, RESIDUAL, figure, save

KNOWN = 2.6  # kg, by the recording's name
LITERATURE = UR10E_GAINS
OWNER = (10.00, 10.70, 8.46, 9.00, 9.48, 10.12)  # N m/A
SHIFT = 0.02  # of a gain's logarithm: the step of the unknown load's derivative


def main() -> None:
    warnings.simplefilter("ignore", pid.PhysidentWarning)  # standard errors from few blocks: intervals say so
    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    files = {
        "February, eight runs": "ur-20_02_*.csv",
        "31 January, one run": "ur-20_01_31-unload.csv",
        "known": "ur-20_01_13-load_2600.csv",
        "unknown": "ur-20_01_31-load.csv",
    }
    sets = {name: pid.load_recordings(str(data / file), UR10E_COLUMNS) for name, file in files.items()}
    february, _, known, unknown = sets.values()
    found = {
        f"{method}, unloaded of {name.split(',')[0]}": pid.identify_drive_gains(robot, sets[name], known, KNOWN, method)
        for method, name in (("tls", files_name) for files_name in list(files)[:2])
    }
    for method in ("physical", "ls"):
        found[f"{method}, unloaded of February"] = pid.identify_drive_gains(robot, february, known, KNOWN, method)
    best = found["tls, unloaded of February"]
    loads = unknown_loads(robot, february, known, unknown, best)
    brackets = ur5_brackets(need_data("ur5"))
    known_truth = simulated_gains()
    rows = [*simulated_rows(known_truth), "", *gain_rows(found), "", *load_rows(loads), "", *bracket_rows(brackets)]
    results = {
        "simulated": known_truth,
        "known_load_kg": KNOWN,
        "published": {"literature": LITERATURE, "owner": OWNER},
        "gains": {name: _relative(gains.as_dict()) for name, gains in found.items()},
        "unknown_load": loads,
        "ur5": brackets,
    }
    draw(best, brackets, Path(__file__).parent / "gains.png")
    keep(Path(__file__).parent, results, "\n".join(rows))


def unknown_loads(
    robot: pid.Robot,
    free: list[pid.Recording],
    known: list[pid.Recording],
    unknown: list[pid.Recording],
    found: pid.DriveGains,
) -> dict[str, dict[str, Any]]:
    """Mass of both loads with each set of gains; with the found one, its uncertainty is carried through."""
    result = {}
    for name, gains in (("literature", np.array(LITERATURE)), ("owner", np.array(OWNER)), ("found", found.gains)):
        arm = pid.identify(robot, with_gains(free, gains))
        both = {
            key: pid.identify_payload(arm, with_gains(one, gains))
            for key, one in (("known", known), ("unknown", unknown))
        }
        result[name] = {f"{key}_mass_kg": load.mass for key, load in both.items()}
        result[name] |= {f"{key}_interval_kg": load.mass_interval.tolist() for key, load in both.items()}
        result[name]["unknown_centre_m"] = both["unknown"].centre.tolist()
        result[name]["ratio_times_known_kg"] = KNOWN * both["unknown"].mass / both["known"].mass
    slope = []
    for j in range(robot.n):
        gains = found.gains * np.exp(SHIFT * (np.arange(robot.n) == j))
        arm = pid.identify(robot, with_gains(free, gains))
        shifted = pid.identify_payload(arm, with_gains(unknown, gains)).mass
        slope.append((shifted - result["found"]["unknown_mass_kg"]) / SHIFT)
    low, high = result["found"]["unknown_interval_kg"]
    from_gains = t_quantile(found.blocks) * float(np.sqrt(np.array(slope) @ found.covariance @ slope))
    half = float(np.hypot((high - low) / 2, from_gains))
    mass = result["found"]["unknown_mass_kg"]
    result["found"] |= {"unknown_interval_with_gains_kg": [mass - half, mass + half], "slope_kg": slope}
    return result


def with_gains(recordings: list[pid.Recording], gains: np.ndarray) -> list[pid.Recording]:
    return [recording.with_drive_gains(gains.tolist()) for recording in recordings]


def simulated_rows(truth: dict[str, Any]) -> list[str]:
    rows = [
        f"simulated UR5, {truth['arms']} arms, load of {truth['load_kg']:g} kg, errors with a memory of {truth['memory_s']} s"
    ]
    rows += [joint_row("joint", range(1, 7), 0)]
    for key, label in (
        ("tls_bias_percent", "tls: mean error [%]"),
        ("tls_rms_percent", "tls: rms error [%]"),
        ("tls_coverage_percent", "tls: 95 % intervals that hold the truth [%]"),
        ("ls_bias_percent", "ls: mean error [%]"),
    ):
        rows.append(joint_row(label, truth[key], 1))
    return [*rows, f"tls: over all joints {truth['tls_coverage_all_percent']:.1f} % of the intervals hold the truth"]


def gain_rows(found: dict[str, pid.DriveGains]) -> list[str]:
    rows = [f"UR10e, drive gains [N m/A] from a load of {KNOWN} kg, its centre of mass not known; 95 % intervals"]
    rows += [joint_row("joint", range(1, 7), 0), joint_row("published: literature", LITERATURE)]
    rows.append(joint_row("published: data owner", OWNER))
    for name, gains in found.items():
        rows.append(joint_row(name, gains.gains))
        if gains.method != "ls":
            rows += [joint_row("  from", gains.intervals[:, 0]), joint_row("  to", gains.intervals[:, 1])]
    return rows


def load_rows(loads: dict[str, dict[str, Any]]) -> list[str]:
    rows = ["UR10e, mass of the loads [kg] with each set of gains (intervals at these gains)"]
    rows.append("gains             known, 2.6 kg           unknown load            unknown / known x 2.6 kg")
    for name, load in loads.items():
        cells = [
            f"{load[f'{key}_mass_kg']:.2f} [{load[f'{key}_interval_kg'][0]:.2f}, {load[f'{key}_interval_kg'][1]:.2f}]"
            for key in ("known", "unknown")
        ]
        rows.append(f"{name:<18}{cells[0]:<24}{cells[1]:<24}{load['ratio_times_known_kg']:.2f}")
    mass, (low, high) = loads["found"]["unknown_mass_kg"], loads["found"]["unknown_interval_with_gains_kg"]
    rows.append(f"unknown load, with the gains' own uncertainty: {mass:.2f} kg, 95 % [{low:.2f}, {high:.2f}]")
    return rows


def bracket_rows(brackets: dict[str, Any]) -> list[str]:
    rows = [
        "UR5, gains [N m/A] that the controller's own rigid-body torque implies, all free movements; 95 % by blocks"
    ]
    rows += [joint_row("joint", range(1, 7), 0)]
    rows += [joint_row(f"published: {name}", gains) for name, gains in GAIN_SETS.items()]
    labels = {
        "lower": "friction, rotor allowed for; current in error",
        "upper": "friction, rotor allowed for; torque in error",
        "lowest": "  95 % of the bracket, from",
        "highest": "  95 % of the bracket, to",
        "no_friction": "left out; torque fitted by current",
        "rms_ratio": "left out; ratio of sizes",
        "correlation": "correlation, friction and rotor allowed for",
    }
    rows += [joint_row(label, brackets[key]) for key, label in labels.items()]
    return [*rows, *(joint_row(f"error [%] with gains: {n}", e, 1) for n, e in brackets["unexplained_percent"].items())]


def draw(found: pid.DriveGains, brackets: dict[str, Any], path: Path) -> None:
    fig, axes = figure(1, 2, size=(4.6, 3.0))
    joints = np.arange(1, 7)
    left, right = axes[0]
    spread = np.abs(found.intervals.T - found.gains)
    left.errorbar(joints, found.gains, spread, fmt="o", color=MEASURED, capsize=3, label="found, 95 %")
    for gains, colour, name in ((LITERATURE, AS_IT_WAS, "literature"), (OWNER, RESIDUAL, "data owner")):
        left.plot(joints, gains, "_", color=colour, markersize=16, markeredgewidth=2, label=name)
    left.set(title="UR10e, load of 2.6 kg", xlabel="joint", ylabel="drive gain [N m/A]", ylim=(0, 25))
    lowest, highest = np.array(brackets["lowest"]), np.array(brackets["highest"])
    right.bar(joints, highest - lowest, bottom=lowest, width=0.35, color=EXTENDED, alpha=0.5, label="bracket, 95 %")
    for (name, gains), colour in zip(GAIN_SETS.items(), (AS_IT_WAS, RESIDUAL), strict=True):
        right.plot(joints, gains, "_", color=colour, markersize=16, markeredgewidth=2, label=name)
    right.set(title="UR5, no known load", xlabel="joint", ylabel="drive gain [N m/A]", ylim=(0, 25))
    for ax in (left, right):
        ax.legend(loc="upper left")
    save(fig, path)


def _relative(data: dict[str, Any]) -> dict[str, Any]:
    return data | {"recordings": [Path(path).name for path in data["recordings"]]}


if __name__ == "__main__":
    main()
