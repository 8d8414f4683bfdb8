"""The study's tables, from its results alone."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from studies.thesis.published import COULOMB

WIDTH = 46


def blocks(r: dict[str, Any]) -> dict[str, list[str]]:
    """The tables by the name of their place in the README."""
    return {
        "trajectories": _trajectories(r["trajectories"]),
        **{f"model {m}": _model(m, r[f"model_{m}"]) for m in "abcd"},
        "friction": _friction(r),
        "diagnosis": _diagnoses(r),
        "coverage": _coverage(r),
        "coupling": _coupling(r),
        "calibration": _calibration(r),
    }


def summary(r: dict[str, Any]) -> list[str]:
    """The thesis' way against ours for the four models, on the whole arm."""
    rows = [_head("Error on the second trajectory [%]")]
    for m in "abcd":
        own = r[f"model_{m}"]
        rows.append(_row(f"{m.upper()}, the thesis' way, two robots", own["error_thesis_way"]))
        rows.append(_row(f"{m.upper()}, the thesis' way, whole arm", own["error_thesis_way_whole_arm"]))
        rows.append(_row(f"{m.upper()}, {own['ours_is']}", own["error_ours"]))
        if any(own["error_noise_alone"]):
            rows.append(_row(f"{m.upper()}, the noise alone", own["error_noise_alone"]))
    return rows


def fill(readme: Path, made: dict[str, list[str]]) -> None:
    """Put each table between the marks of its name; ends the study where a mark is missing."""
    text = readme.read_text(encoding="utf-8")
    for name, rows in made.items():
        block = "\n".join([f"<!-- {name} -->", "```", *rows, "```", f"<!-- /{name} -->"])
        text, count = re.subn(rf"<!-- {name} -->.*?<!-- /{name} -->", lambda _, block=block: block, text, flags=re.S)
        if count != 1:
            sys.exit(f"{readme}: {count} blocks named {name!r}, expected one")
    readme.write_text(text, encoding="utf-8")


def _row(label: str, values: Any, form: str = "{:.3g}") -> str:
    return f"{label:<{WIDTH}}" + "".join(f"{form.format(0.0 if abs(v) < 1e-6 else v):>10}" for v in values)


def _head(title: str) -> str:
    return f"{title:<{WIDTH}}" + "".join(f"{f'J{j}':>10}" for j in range(1, 7))


def _model(name: str, m: dict[str, Any]) -> list[str]:
    rows = [_head(f"Model {name.upper()}: error on the second trajectory [%]")]
    rows.append(_row("the thesis' way, two robots of three joints", m["error_thesis_way"]))
    rows.append(_row("the thesis' way, one arm of six", m["error_thesis_way_whole_arm"]))
    for way, found in m["ours"].items():
        rows.append(f"{way}: not solved" if "not_solved" in found else _row(way, found["error"]))
    if any(m["error_noise_alone"]):
        rows.append(_row("the noise alone", m["error_noise_alone"]))
        rows.append(_row("  the noise alone, RMS [N m]", m["rms_noise"]))
        rows += [
            _row("  ours to the noise-free torque, RMS [N m]", f["rms"])
            for way, f in m["ours"].items()
            if way == "ours, physical, designed trajectory" and "rms" in f
        ]
    if name == "b":
        rows.append(_row("true parameters, the default sign", m["error_of_truth_with_default_sign"]))
    if name == "a":
        rows += [
            f"{way}: base parameters off by {f['base_parameters_off_relative']:.1e} of themselves at most"
            for way, f in m["ours"].items()
            if "base_parameters_off_relative" in f
        ]
    return rows


def _friction(r: dict[str, Any]) -> list[str]:
    rows = [_head("Coulomb friction [N m]"), _row("Table 2.5 times 101", COULOMB, "{:.4f}")]
    for m in "bd":
        for way, found in r[f"model_{m}"]["ours"].items():
            if "error" in found:
                rows.append(_row(f"{m.upper()} {way}", found["friction"], "{:.4f}"))
    return rows


def _diagnoses(r: dict[str, Any]) -> list[str]:
    rows = ["Diagnosis of recordings of the independent plant"]
    reference, shifted = r["model_b"]["diagnosis_of_the_reference"], r["joint_zero_offset"]
    cases = [(f"model {m.upper()}", r[f"model_{m}"]["diagnosis"]) for m in "bd"]
    for name, found in [*cases, ("model B, the reference itself", reference), ("shifted zero", shifted)]:
        rows.append(f"{name}, question: {found['question']}; verdict: {found['verdict']}")
        for f in found["findings"]:
            rivals = f" or {', '.join(v['effect'] for v in f['rivals'])}" if f["rivals"] else ""
            rows.append(f"  {f['effect']}, joints {', '.join(map(str, f['joints'])) or 'all'}{rivals}")
            rows += [f"    J{v['joint']} {v['name']} {v['value']:.4g} [{v['interval95'][0]:.4g}, {v['interval95'][1]:.4g}] {v['unit']}" for v in f["parameters"]]  # fmt: skip
    return rows


def _coverage(r: dict[str, Any]) -> list[str]:
    rows = ["95 % intervals over draws of the noise   coverage %   lowest  highest   parameter error %"]
    for m, by in r["coverage"].items():
        for motion, c in by.items():
            rows.append(
                f"model {m.upper()}, {motion:<9} {c['draws']:4d} draws{c['coverage_percent']:23.1f}"
                f"{c['lowest_percent']:9.1f}{c['highest_percent']:9.1f}{c['parameter_error_percent']:16.2f}"
            )
    return rows


def _coupling(r: dict[str, Any]) -> list[str]:
    c = r["coupling"]
    rows = [_head("Coupling left out (eq. 4.3), model A [%]")]
    rows.append(_row("true parameters", c["true_parameters"]["error"]))
    rows.append(_row("parameters fitted without it", c["fitted"]["error"]))
    rows.append(_row("  the same, RMS [N m]", c["fitted"]["rms"]))
    return [*rows, _row("  on the trajectory that was fitted", c["fitted_on_its_own_trajectory"])]


def _trajectories(t: dict[str, Any]) -> list[str]:
    names = ("thesis", "designed", "validation")
    rows = [f"{'Trajectories':<{WIDTH}}" + "".join(f"{name:>12}" for name in names)]
    entries = {
        "cond(Y_B), base-shoulder-elbow, 15": lambda p: p["cond"]["bse"],
        "cond(Y_B), wrist, 15": lambda p: p["cond"]["w"],
        "cond(Y_B), whole arm, 36": lambda p: p["cond"]["whole"],
        "share of the position limits": lambda p: p["q_used"],
        "share of the velocity limits": lambda p: p["v_used"],
        "share of the acceleration limits": lambda p: p["a_used"],
        "largest velocity at the start [rad/s]": lambda p: p["v_start"],
        "largest acceleration at the start [rad/s^2]": lambda p: p["a_start"],
        "tool speed at most [m/s]": lambda p: p["tool_speed"],
        "lowest joint centre or tool above the base [m]": lambda p: p["lowest_joint"],
        "manipulability, least [m^3]": lambda p: p["manipulability"]["lowest"],
        "manipulability, median [m^3]": lambda p: p["manipulability"]["median"],
        "share of the motion near a singularity": lambda p: p["manipulability"]["near_singular_share"],
    }
    rows += [
        f"{label:<{WIDTH}}" + "".join(f"{get(t[name]):>12.4g}" for name in names) for label, get in entries.items()
    ]
    rows += ["", f"{'Designed for, by':<{WIDTH}}{'cond(Y_B)':>12}{'time':>12}"]
    labels = {"bse": "base-shoulder-elbow", "w": "wrist"}
    for name, label in labels.items():
        cond, hours = t["reported"]["cond"][name], t["reported"]["hours"][name]
        rows.append(f"{label + ', the thesis':<{WIDTH}}{cond:>12.1f}{hours:>10.0f} h")
    for name, one in t["ours"].items():
        rows.append(
            f"{f'{labels.get(name, name)}, ours':<{WIDTH}}{one['cond']:>12.1f}{one['processor_seconds']:>10.0f} s"
        )
    return rows


def _calibration(r: dict[str, Any]) -> list[str]:
    d = r["dh_calibration"]
    rows = [_head(f"Uncalibrated geometry ({1000 * d['length_std_m']:g} mm, {d['angle_std_deg']:g} deg) [%]")]
    rows.append(_row("true link parameters", d["true_links"]["error"]))
    rows.append(_row("  RMS [N m]", d["true_links"]["rms"]))
    return [*rows, _row("link parameters fitted with it", d["fitted_links"]["error"])]
