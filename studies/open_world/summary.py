"""The figures of a set of trials, overall and by what was drawn, and the table that a reader gets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

WITHIN = 15.0  # % of a value
Row = dict[str, Any]
STRATA = ("friction", "arm", "motion", "sensor", "background", "plant", "question", "temperature", "tier")


def share(hits: Sequence[bool]) -> dict[str, float]:
    """Percentage of hits with its 95 % interval (Wilson, 1927)."""
    n, z = len(hits), 1.96
    if not n:
        return {"n": 0, "percent": 0.0, "low": 0.0, "high": 100.0}
    p = float(np.mean(hits))
    middle, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    low, high = (100 * (middle + sign * half) / (1 + z * z / n) for sign in (-1, 1))
    return {"n": n, "percent": 100 * p, "low": float(max(low, 0.0)), "high": float(min(high, 100.0))}


def _seen(rows: Sequence[Row]) -> list[Row]:
    return [r["score"] for r in rows if r["kind"] == "single" and "score" in r and r["tier"] in ("middle", "strong")]


def _weak(rows: Sequence[Row]) -> list[Row]:
    return [r["score"] for r in rows if r["kind"] == "single" and "score" in r and r["tier"] == "weak"]


def _twins(rows: Sequence[Row]) -> list[Row]:
    return [r["twin"] for r in rows if "twin" in r]


def _pairs(rows: Sequence[Row]) -> list[Row]:
    return [r["score"] for r in rows if r["kind"] == "pair" and "score" in r]


def _outside(rows: Sequence[Row]) -> list[Row]:
    return [r["outside_score"] for r in rows if "outside_score" in r]


def _holds_truth(score: Row) -> bool | None:
    """Whether the interval of a value holds the true one; None where several values decide."""
    ends = score.get("interval")
    return None if ends is None else ends[0] <= 1 <= ends[1]


Figure = tuple[str, Callable[[Sequence[Row]], list[Row]], Callable[[Row], bool | None]]
FIGURES: dict[str, Figure] = {
    "first": ("middle and strong: right cause first, alone or in its class", _seen, lambda s: s["first"]),
    "alone": ("  right cause first and alone", _seen, lambda s: s["alone"]),
    "silent": ("  nothing named", _seen, lambda s: s["told"] == "nothing"),
    "lesser": ("  listed, but as less than a cause", _seen, lambda s: s["lesser"] and not s["named"]),
    "others": ("  a false cause beside it or instead", _seen, lambda s: s["others"] > 0),
    "value": (f"  value, where named, within {WITHIN:g} %", _seen, lambda s: s["error"] <= WITHIN),
    "interval": ("  truth in the interval, where one value decides", _seen, _holds_truth),
    "weak_first": ("weak: right cause first", _weak, lambda s: s["first"]),
    "weak_wrong": ("weak: a false cause", _weak, lambda s: s["others"] > 0),
    "twin_false": ("clean twins accused of a false cause", _twins, lambda t: t["false"] > 0),
    "twin_any": ("  accused of anything, true friction laws included", _twins, lambda t: t["false"] + t["own"] > 0),
    "twin_described": ("  something described on them, by chance or background", _twins, lambda t: t["described"]),
    "both": ("pairs: both named", _pairs, lambda s: s["named"]),
    "pair_first": ("pairs: one of them first", _pairs, lambda s: s["first"]),
    "third": ("pairs: a false third", _pairs, lambda s: s["others"] > 0),
    "outside_wrong": ("outside the catalogue: a confident wrong name", _outside, lambda s: s["wrong"]),
    "outside_joint": ("  a right joint in whatever is told", _outside, lambda s: s["joint"]),
    "outside_told": ("  no wrong name, and a description on a right joint", _outside,
                     lambda s: not s["wrong"] and s["right_description"]),
    "outside_variable": ("  a curve of the right variable on a right joint, where a variable is right", _outside,
                         lambda s: s.get("variable")),
    "outside_silent": ("  silence", _outside, lambda s: s["silent"]),
}  # fmt: skip


def figure(key: str, rows: Sequence[Row]) -> dict[str, float]:
    """One figure over some rows."""
    _, choose, hit = FIGURES[key]
    chosen = choose(rows)
    if key == "value":
        chosen = [s for s in chosen if s["error"] is not None]
    answers = [hit(s) for s in chosen]
    return share([bool(answer) for answer in answers if answer is not None])  # None: this was not counted


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """All figures of one set, overall and by stratum."""
    # a trial that ended early has no stages
    spent = [r["seconds"] for r in rows if "seconds" in r and not r.get("failed")]
    return {
        "rows": len(rows),
        "refused": share(["refused" in r for r in rows]),
        "failed": share(["failed" in r for r in rows]),
        "reasons": Counter(str(r.get("refused") or r.get("failed"))[:90] for r in rows if "refused" in r or "failed" in r),
        "figures": {key: figure(key, rows) for key in FIGURES},
        "strata": {name: _by(name, rows) for name in STRATA},
        "effects": _by_cause(rows),
        "outside": _by_kind(rows),
        "seconds": {stage: float(np.mean([s[stage] for s in spent])) for stage in spent[0]} if spent else {},
    }  # fmt: skip


def _by(name: str, rows: Sequence[Row]) -> dict[str, dict[str, dict[str, float]]]:
    """The main figures in each stratum; a row that has several backgrounds counts with each."""
    groups: dict[str, list[Row]] = {}
    for r in rows:
        own = r["strata"].get(name) if "strata" in r else None
        for value in own if isinstance(own, list) else [own]:
            if value is not None:
                groups.setdefault(str(value), []).append(r)
    keys = ("first", "others", "twin_false", "both", "outside_wrong")
    return {value: {key: figure(key, own) for key in keys} for value, own in sorted(groups.items())}


def _by_cause(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    """For each hidden effect, what stood in first place: its name, another, or nothing."""
    result: dict[str, Counter[str]] = {}
    for r in rows:
        if r["kind"] == "single" and r.get("tier") in ("middle", "strong") and "score" in r:
            effect, s = r["hidden"][0]["effect"], r["score"]
            named = effect if s["first"] else s["told"].split("; ")[0].split(" or ")[0]
            result.setdefault(effect, Counter())[named] += 1
    return {effect: dict(counts) for effect, counts in sorted(result.items())}


def _by_kind(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    """For each outside cause, how often a wrong name, a description on a right joint or silence came."""
    result: dict[str, Counter[str]] = {}
    for r in rows:
        if "outside_score" in r:
            s, counts = r["outside_score"], result.setdefault(r["outside"], Counter())
            counts["all"] += 1
            for key in ("wrong", "joint", "right_description", "silent"):
                counts[key] += bool(s[key])
    return {kind: dict(counts) for kind, counts in sorted(result.items())}


def table(one: dict[str, Any]) -> str:
    """The figures of one set as text."""
    lines = [f"{'refused by physident (every row counts)':<62}{_cell(one['refused'])}"]
    if one["failed"]["percent"]:
        lines.append(f"{'failed with another error':<62}{_cell(one['failed'])}")
    lines += [f"  {count} x {reason}" for reason, count in one["reasons"].items()]
    for key, (label, _, _) in FIGURES.items():
        value = one["figures"].get(key)  # older results lack what was counted later
        lines.append(f"{label:<62}{_cell(value) if value and value['n'] else 'not counted'}")
    lines += ["", f"{'by what was drawn':<24}" + "".join(f"{head:>21}" for head in HEADS)]
    for name in STRATA:
        lines.append(name)
        for value, own in one["strata"][name].items():
            lines.append(f"  {value:<22}" + "".join(f"{_short(cell):>21}" for cell in own.values()))
    lines += ["", "middle and strong: what was named instead"]
    for effect, counts in one["effects"].items():
        wrong = ", ".join(f"{told} ({n})" for told, n in counts.items() if told != effect)
        lines.append(f"  {effect:<28}{counts.get(effect, 0):>3} of {sum(counts.values()):<3} {wrong}")
    lines += ["", "outside the catalogue              of   wrong name   right joint   described there   silence"]
    for kind, c in one["outside"].items():
        lines.append(
            f"  {kind:<30}{c['all']:>5}{c['wrong']:>13}{c['joint']:>14}{c['right_description']:>18}{c['silent']:>10}"
        )
    spent = ", ".join(f"{stage} {seconds:.1f} s" for stage, seconds in one["seconds"].items())
    return "\n".join([*lines, "", f"processor time a trial: {spent}"])


HEADS = ("right first", "false beside", "twin accused", "both of a pair", "outside misnamed")


def _cell(value: dict[str, float]) -> str:
    return f"{value['percent']:6.1f} % [{value['low']:.0f}, {value['high']:.0f}] of {value['n']}"


def _short(value: dict[str, float]) -> str:
    return "-" if not value["n"] else f"{value['percent']:.0f} [{value['low']:.0f}, {value['high']:.0f}] /{value['n']}"
