"""The figures of a set of blind trials, and the table that a reader gets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

WITHIN = 10.0  # % of a value
ASKED = {
    "first": 95.0, "alone": 85.0, "mean_class": 1.5, "largest_class": 3.0, "value": 90.0, "gain": 90.0, "false": 2.0,
    "weak_wrong": 5.0, "both": 80.0, "third": 5.0, "seconds": 8.0,
}  # fmt: skip


def share(hits: Sequence[bool]) -> dict[str, float]:
    """Percentage of hits with its 95 % interval (Wilson, 1927)."""
    n, p, z = len(hits), float(np.mean(hits)) if len(hits) else 0.0, 1.96
    if not n:
        return {"n": 0, "percent": 0.0, "low": 0.0, "high": 100.0}
    middle, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    low, high = (100 * (middle + sign * half) / (1 + z * z / n) for sign in (-1, 1))
    return {"n": n, "percent": 100 * p, "low": float(max(low, 0.0)), "high": float(min(high, 100.0))}


def summary(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """All figures of one set."""
    single = [r for r in rows if len(r["hidden"]) == 1]
    pairs = [r["score"] for r in rows if len(r["hidden"]) == 2]
    seen = [r["score"] for r in single if r["tier"] in ("middle", "strong")]
    weak = [r["score"] for r in single if r["tier"] == "weak"]
    hidden = [r["score"] for r in single if r["tier"] == "invisible"]
    sizes = [s["size"] for s in seen if s["first"]]
    errors = [s["error"] for s in seen if s["error"] is not None]
    gains = [s["gain"] for s in seen if s["gain"] is not None]
    twins = [r["twin"] for r in single]
    seconds = [s["seconds"] for s in (*seen, *weak, *hidden, *pairs)] + [t["seconds"] for t in twins]
    return {
        "trials": len(single),
        "pairs": len(pairs),
        "twins": len(twins),
        "first": share([s["first"] for s in seen]),
        "listed": share([s["listed"] for s in seen]),
        "alone": share([s["alone"] for s in seen]),
        "first_by_tier": {t: share([r["score"]["first"] for r in single if r["tier"] == t]) for t in ("middle", "strong")},
        "first_by_question": {
            q: share([r["score"]["first"] for r in single if r["question"] == q and r["tier"] in ("middle", "strong")])
            for q in ("different", "missing", "nominal")
        },
        "mean_class": float(np.mean(sizes)) if sizes else None,
        "largest_class": max(sizes, default=0),
        "more_than_hidden": share([s["others"] > 0 for s in seen]),
        "value": share([e <= WITHIN for e in errors]),
        "gain": float(np.median(gains)) if gains else None,
        "false": share([bool(t["found"]) for t in twins]),
        "listed_on_twins": share([bool(t["listed"]) for t in twins]),
        "placebos_passed": sum(t["placebos"] for t in twins),
        "weak_wrong": share([s["told"] != "nothing" and not s["first"] for s in weak]),
        "weak_named": share([s["first"] for s in weak]),
        "weak_listed": share([s["listed"] for s in weak]),
        "cannot_tell": share([s["unseen"] and not s["others"] for s in hidden]),
        "both": share([s["named"] for s in pairs]),
        "third": share([s["others"] > 0 for s in pairs]),
        "seconds": {"median": float(np.median(seconds)), "largest": max(seconds)},
        "confusion": confusion([r for r in single if r["tier"] in ("middle", "strong")]),
    }  # fmt: skip


def confusion(rows: Sequence[dict[str, Any]]) -> dict[str, dict[str, int]]:
    """For each hidden effect, what stood in first place: its own name, another effect's, its own on other joints, nothing."""
    result: dict[str, Counter[str]] = {}
    for r in rows:
        (h,) = r["hidden"]
        told = r["score"]["told"].split("; ")[0]
        named = h["effect"] if r["score"]["first"] else told.split(" or ")[0]
        result.setdefault(h["effect"], Counter())[named] += 1
    return {effect: dict(counts) for effect, counts in sorted(result.items())}


def table(sets: dict[str, dict[str, Any]]) -> str:
    """The figures of one set or several beside what was asked."""
    lines = [
        ("hidden effect named first, alone or in a class", "first", ">= 95 %"),
        ("named first and alone", "alone", ">= 85 %"),
        ("listed first, as a cause or as less", "listed", ""),
        ("mean size of its class", "mean_class", "<= 1.5"),
        ("largest class", "largest_class", "<= 3"),
        ("causes beyond it", "more_than_hidden", ""),
        ("value (or torque of a shape) within 10 %", "value", ">= 90 %"),
        ("  chance of it who knows cause, place and shape", "attainable", ""),
        ("median held-out gain, of the oracle's", "gain", ">= 90 %"),
        ("clean twins accused of something", "false", "<= 2 %"),
        ("something listed of clean twins, as a cause or as less", "listed_on_twins", ""),
        ("weak effects: a confident wrong name", "weak_wrong", "<= 5 %"),
        ("weak effects named", "weak_named", ""),
        ("weak effects listed first, as a cause or as less", "weak_listed", ""),
        ("invisible cells: said so, and nothing else", "cannot_tell", ""),
        ("pairs: both named", "both", ">= 80 %"),
        ("pairs: a third one named", "third", "<= 5 %"),
    ]
    head = f"{'':<56}{'asked':>9}" + "".join(f"{name:>26}" for name in sets)
    rows = [head]
    for label, key, wanted in lines:
        rows.append(f"{label:<56}{wanted:>9}" + "".join(f"{_cell(one.get(key)):>26}" for one in sets.values()))
    rows.append(
        f"{'processor time of a diagnosis, median and largest':<56}{'<= 8 s':>9}"
        + "".join(f"{one['seconds']['median']:>17.1f}, {one['seconds']['largest']:.1f} s" for one in sets.values())
    )
    for name, one in sets.items():
        rows += ["", f"{name}: what was named instead, of {one['first']['n']} in the middle and strong tiers"]
        for effect, counts in one["confusion"].items():
            wrong = ", ".join(f"{told} ({n})" for told, n in counts.items() if told != effect)
            rows.append(f"  {effect:<28}{counts.get(effect, 0):>3} of {sum(counts.values()):<3} {wrong}")
    return "\n".join(rows)


def _cell(value: Any) -> str:
    if isinstance(value, dict):
        return f"{value['percent']:.1f} [{value['low']:.0f}, {value['high']:.0f}] of {value['n']}"
    return "-" if value is None else f"{value:.4g}"
