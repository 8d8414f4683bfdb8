"""Writes the tables of docs/measured.md and of README from the studies' kept results, so that no number is typed by hand."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))
from peer_tables import beside_others, compared

ROOT = Path(__file__).resolve().parents[1]


def results(study: str) -> dict[str, Any]:
    """What a study kept."""
    return json.loads((ROOT / "studies" / study / "results.json").read_text(encoding="utf-8"))


def _contact_in(findings: list[dict[str, Any]]) -> str:
    """What a diagnosis of an arm that nothing touched says of contacts."""
    grades = [finding["grade"] for finding in findings if finding["effect"] == "contact"]
    if "cause" in grades:
        return "a contact, falsely"
    return f"a contact as a {grades[0]} only" if grades else "no contact"


def real_arms() -> str:
    """Errors of the default model on real recordings that were not fitted."""
    ur10e, ur5 = results("ur10e_baseline"), results("ur5_baseline")
    rows = ["| arm, judged on | " + " | ".join(f"J{j}" for j in range(1, 7)) + " |", "|---|" + "---|" * 6]
    cases = {
        f"UR10e, each of eight runs left out once, {ur10e['cutoff']:g} Hz": ur10e["wls"]["mean"],
        f"UR5, move8 after fitting three others, {ur5['cutoff']:g} Hz": ur5["relative_percent"]["move8"],
    }
    rows += [f"| {name} | " + " | ".join(f"{v:.1f}" for v in values) + " |" for name, values in cases.items()]
    return "\n".join(rows)


def _designed() -> list[tuple[str, str, str]]:
    """What designed motions reach, and what they bring."""
    kept = results("excitation")
    pays, medians = kept["pays"], {}
    for name in ("whole", "all_limits"):
        found = kept["designed"][name]
        medians[name] = [sorted(found[key])[len(found[key]) // 2] for key in ("condition", "processor_seconds")]
    (joint, joint_seconds), (every, every_seconds) = medians["whole"], medians["all_limits"]
    return [
        (
            f"condition number of a motion designed for a UR5's 36 base parameters (thesis: {kept['thesis']['whole']:.0f} after 218 h)",
            f"{joint:.1f} in {joint_seconds:.0f} s of processor time; {every:.1f} in {every_seconds:.0f} s with torque, tool, table and links",
            "excitation",
        ),
        (
            "errors of 58 parameters from 20 s of random motion, over those from a designed one, median",
            f"{pays['joint']['median_ratio']:.1f} within joint limits, {pays['all']['median_ratio']:.0f} within all",
            "excitation",
        ),
    ]


def _diagnosed() -> list[tuple[str, str, str]]:
    """How often a diagnosis is right, in blind trials, and how long it takes."""
    sets = results("blind_trials")["sets"].values()
    apart, eight = results("discriminating"), results("diagnosis_speed")
    worlds, loop = results("open_world")["worlds"], results("active")["loop"]["summary"]
    again, other = worlds["again"]["figures"], worlds["first"]["figures"]
    both_seconds = f"{max(one['seconds']['median'] for one in sets):.1f} s of processor time, at most {max(one['seconds']['largest'] for one in sets):.1f}"

    def both(key: str) -> str:
        percents = " and ".join(f"{one[key]['percent']:.0f} %" for one in sets)
        sizes = " and ".join(str(n) for n in dict.fromkeys(one[key]["n"] for one in sets))
        which = "one set" if len(sets) == 1 else f"{len(sets)} independent sets"
        return f"{percents} ({which} of {sizes} trials)"

    return [
        (
            "a hidden effect is named first, alone or with rivals; blind trials, friction law shared with the estimator",
            both("first"),
            "blind_trials",
        ),
        ("... or listed first, as a cause or as less than one", both("listed"), "blind_trials"),
        ("... and alone", both("alone"), "blind_trials"),
        (
            "... its value within 10 % (an oracle that is given the effect, its joint and its shape)",
            " and ".join(f"{one['value']['percent']:.0f} % ({one['attainable']:.0f} %)" for one in sets),
            "blind_trials",
        ),
        ("healthy arms accused of something", both("false"), "blind_trials"),
        ("two hidden effects are both named", both("both"), "blind_trials"),
        ("a diagnosis of two recordings of 20 s", both_seconds, "blind_trials"),
        (
            f"a diagnosis of {eight['recordings']} runs of a UR10e, {eight['seconds'] / 60:.0f} minutes",
            f"{eight['processor_s']:.0f} s of processor time",
            "diagnosis_speed",
        ),
        (
            "what is different in arms with physics that no model has, along repeated motions (any question, along others): named first; untouched arms accused",
            f"{again['first']['percent']:.0f} % and {again['twin_false']['percent']:.0f} % ({other['first']['percent']:.0f} % and"
            f" {other['twin_false']['percent']:.0f} %)",
            "open_world",
        ),
        (
            "one to three changes of such an arm, each named alone with its value after one planned minute (one of random motions)",
            f"{loop['named_first']['planned']} of {loop['arms']} arms ({loop['named_first']['random']})",
            "active",
        ),
        (
            "rivals that ordinary motions left undecided, told apart on the motion designed for them",
            f"{apart['separated']} of {apart['of']}",
            "discriminating",
        ),
    ]


def _simulated() -> list[tuple[str, str, str]]:
    """What exports and replays show."""
    kept = results("replay")
    hidden, other = kept["b"], {name: one for name, one in kept["e"].items() if isinstance(one, dict)}
    worst = max(one["patched"] / one["truth"] for one in hidden.values() if isinstance(one, dict))
    gain = [
        f"{1e3 * kept['a'][s]['before']['tool']:.0f} → {1e3 * kept['a'][s]['after']['tool']:.0f}"
        for s in ("mujoco", "physident")
    ]
    parts = ("armature", "damping", "frictionloss")
    ours, theirs = other["physident"], [one for name, one in other.items() if name.startswith("mujoco.sysid")]
    own = [ours[part] for part in parts]
    best = [min(one[part] for one in theirs) for part in parts]
    return [
        (
            "a hidden effect found and patched into a MuJoCo file: half a second ahead it errs as the true arm's file does, to 5 %",
            f"{hidden['within_5_percent']} of {hidden['arms']} arms, the worst {worst:.2f} times",
            "replay",
        ),
        (
            "the tool of a UR10e half a second ahead, before and after its diagnosis, on a run that was not fitted",
            f"{gain[0]} mm in MuJoCo, {gain[1]} mm in physident's simulator",
            "replay",
        ),
        (
            "28 parameters from one simulated recording: errors of armature, damping and dry friction (mujoco.sysid, the best of its settings)",
            f"{min(own):.1f} to {max(own):.1f} % in {ours['s']:.1f} s of processor time ({min(best):.1f} to {max(best):.1f} % in {min(one['s'] for one in theirs):.0f} s and more)",
            "replay",
        ),
    ]


def measured() -> str:
    """What the studies on known truths show, a line each."""
    coverage = results("calibration")["coverage"]
    recovery, load = results("effects_recovery"), results("payload")["simulated"]["2.6"]
    speed, fit, minute = results("regressor_speed"), results("estimation_speed"), results("simulation")["minute"]
    session = results("view_speed")
    honest, textbook = coverage["wls"], coverage["textbook"]
    rows = [
        (
            "coverage of 95 % intervals under correlated noise",
            f"{honest['lowest_percent']:.1f} to {honest['highest_percent']:.1f} % of identifications (textbook ones: {textbook['lowest_percent']:.0f} to {textbook['highest_percent']:.0f} %)",
            "calibration",
        ),
        (
            "an effect hidden by an independent plant and given to `identify` is recovered within 5 % or its interval",
            f"{recovery['passed']} of {recovery['of']} parameters",
            "effects_recovery",
        ),
        (
            "a 2.6 kg load from 20 s of motion, worst of eight simulated arms",
            f"{load['mass_worst_percent']:.1f} % of mass, {load['centre_worst_mm']:.1f} mm",
            "payload",
        ),
        (
            "from signals to the compressed factor",
            f"{speed['ratio']:.0f} times as fast as a direct implementation",
            "regressor_speed",
        ),
        (
            "a physical estimate with its proof, 84 parameters",
            f"{1000 * fit['median_s'][1]:.0f} ms of processor time (plain script {1000 * fit['plain_s'][1]:.0f} ms)",
            "estimation_speed",
        ),
        (
            "one minute of a simulated UR5 with dry friction",
            f"{minute['processor']:.1f} s of processor time",
            "simulation",
        ),
        (
            "a session of one minute of a 6-joint arm, two models; of ten minutes",
            f"{session['one minute']['processor']:.1f} s of processor time; {session['ten minutes']['megabytes']:.0f} MB",
            "view_speed",
        ),
    ]
    noisy = results("thesis")["model_d"]
    ours, floor, plain = noisy["error_ours"], noisy["error_noise_alone"], noisy["error_thesis_way"]
    rows.append(
        (
            "the thesis the project grew from, its model with friction and noise: torque errors",
            f"{min(ours):.1f} to {max(ours):.1f} %, of which the noise is {min(floor):.1f} to {max(floor):.1f} (the thesis's method: {min(plain):.0f} to {max(plain):.0f} %)",
            "thesis",
        )
    )
    rows += _simulated() + _diagnosed() + _designed()
    lines = ["| what | figure | study |", "|---|---|---|"]
    return "\n".join(
        lines + [f"| {what} | {figure} | [{study}](../studies/{study}/README.md) |" for what, figure, study in rows]
    )


def found_on_real_arms() -> str:
    """What diagnosis names on real recordings, and how much better its extended model predicts what nothing saw."""
    parts = results("real_arms")
    a, b, c, d, e, f = (parts[letter] for letter in "abcdef")
    loads = b["diagnoses"]
    poses = f["at_rest"]["poses"]
    held = max(abs(h) for pose in poses for h in pose["held"])
    pushed = [finding for finding in d["pushed"]["findings"] if finding["effect"] == "contact"]
    rows = [
        ("UR10e, what the default model misses", named(a["diagnosis"]["findings"]),
         f"left-out runs {errors(a['left_out_mean']['before'])} → {errors(a['left_out_mean']['after'])}"),
        *((f"UR10e, {label}", named(loads[label]["findings"]).replace("`payload`", "`payload`" + mass(b["mass"][label])),
           f"{errors(one['before_percent'])} → {errors(one['after_percent'])}" if one["findings"] else "")
          for label, one in loads.items()),
        ("TX40, what the default model misses, from half its recording", named(c["half"]["findings"]),
         f"the other half {errors(c['unseen']['before'])} → {errors(c['unseen']['after'])}"),
        ("UR5, pushed by hand five times", named(pushed), f"{d['met']} of {len(d['pushes'])} pushes, {d['wrong']} false"),
        ("UR5, the same motion untouched", named(d["clean"]["findings"]), _contact_in(d["clean"]["findings"])),
        ("UR5, a simulation from its table", named(e["diagnosis"]["findings"]),
         f"move8 {errors(e['errors']['move8']['the table alone'])} → {errors(e['errors']['move8']['extended by diagnosis'])}"),
        ("UR10e at rest, three poses", "nothing beyond static friction" if not f["at_rest"]["outside"] else
         f"more than static friction can explain on joints {', '.join(map(str, f['at_rest']['outside']))}",
         f"torque up to {held:.1f} N m from gravity"),
    ]  # fmt: skip
    lines = [
        "| arm and question | what `diagnose` names (joints) | relative error [%], joints 1 to 6 |",
        "|---|---|---|",
    ]
    return "\n".join(lines + [f"| {question} | {answer} | {figure} |" for question, answer, figure in rows])


def named(findings: list[dict[str, Any]]) -> str:
    """Names and joints of the causes among findings, and in how many of 20 searches the first was found."""
    causes = [f for f in findings if f["grade"] == "cause"]
    texts = [f"`{f['effect']}`" + (f" ({joints(f['joints'])})" if f["joints"] else "") for f in causes]
    if len(causes) == 1 and causes[0]["stability"] is not None:
        texts[0] += f", found in {round(20 * causes[0]['stability'])} of 20 searches"
    return ", ".join(texts) or "nothing"


def joints(numbers: list[int]) -> str:
    """Joints in few signs: three and more in a row as a range."""
    row = numbers == list(range(numbers[0], numbers[-1] + 1)) and len(numbers) > 2
    return f"{numbers[0]} to {numbers[-1]}" if row else ", ".join(map(str, numbers))


def mass(value: dict[str, Any] | None) -> str:
    """A found mass with its interval, by the drive gains as they were given."""
    if value is None:
        return ""
    low, high = value["interval95"]
    return f" of {value['value']:.2f} kg [{low:.2f}, {high:.2f}] (plus the uncertainty of the drive gains)"


def errors(values: list[float]) -> str:
    """Errors of all joints."""
    return " ".join(f"{value:.1f}" for value in values)


def in_short() -> str:
    """The few figures of README, in plain words."""
    honest, arms = results("calibration")["coverage"]["wls"], results("real_arms")
    sets, load = list(results("blind_trials")["sets"].values()), results("payload")["simulated"]["2.6"]
    left, worlds = arms["a"]["left_out_mean"], results("open_world")["worlds"]
    world, again = worlds["first"]["figures"], worlds["again"]["figures"]
    named_first, listed = (min(one[key]["percent"] for one in sets) for key in ("first", "listed"))
    accused = max(one["false"]["percent"] for one in sets)
    return "\n".join(
        [
            f"- Real UR10e, runs that were not fitted: the default model errs by {errors(left['before'])} % on joints 1 to 6, the"
            f" model extended by its diagnosis by {errors(left['after'])} %.",
            f"- Simulated arms with one hidden effect that is a tenth of a joint's error or more: it is named first in {named_first:.0f} % of trials and"
            f" listed first in {listed:.0f} %; a healthy arm is accused in {accused:.0f} %. The friction law there is the estimator's own; on arms with other physics, and"
            f" sensors, motions and faults of their own, these are {world['first']['percent']:.0f} % and"
            f" {world['twin_false']['percent']:.0f} %, and {again['first']['percent']:.0f} % and {again['twin_false']['percent']:.0f} % where a change is asked"
            " for and a motion of the healthy arm is repeated ([open world](studies/open_world/README.md)).",
            f"- Confidence intervals of 95 % hold the true value in {honest['lowest_percent']:.0f} to"
            f" {honest['highest_percent']:.0f} % of identifications, with correlated noise.",
            f"- A load of 2.6 kg is weighed to {load['mass_worst_percent']:.1f} % or better from 20 s of simulated motion.",
        ]
    )


PAGES = {
    ROOT / "docs" / "measured.md": {
        "real arms": real_arms,
        "found on real arms": found_on_real_arms,
        "measured": measured,
        "beside others": beside_others,
    },
    ROOT / "README.md": {"in short": in_short, "compared": compared},
}


def filled(page: Path) -> str:
    """The text of a page with every marked block made anew."""
    text = page.read_text(encoding="utf-8")
    for name, make in PAGES[page].items():
        block = f"<!-- {name} -->\n{make()}\n<!-- /{name} -->"
        text, count = re.subn(rf"<!-- {name} -->.*?<!-- /{name} -->", lambda _, block=block: block, text, flags=re.S)
        if count != 1:
            raise SystemExit(f"{page.name}: {count} blocks named {name!r}, expected one")
    return text


if __name__ == "__main__":
    for page in PAGES:
        page.write_text(filled(page), encoding="utf-8")
