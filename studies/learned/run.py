"""Are curves learned where no law is known, on the right joint and of the right variable, and nowhere else?"""

from __future__ import annotations

import argparse
import json
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: one process a core
os.environ.setdefault("OMP_NUM_THREADS", "1")

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from studies.kept import keep
from studies.learned.causes import OUTSIDE
from studies.learned.trial import judge

FOLDER = Path(__file__).parent


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--outside", type=int, default=60)
    parser.add_argument("--inside", type=int, default=60)
    parser.add_argument("--first", type=int, default=0, help="number of the first trial; 0 is reported")
    parser.add_argument("--dry", action="store_true", help="print the table and keep nothing")
    asked = parser.parse_args()
    jobs = [
        (kind, asked.first + k)
        for kind, count in (("outside", asked.outside), ("inside", asked.inside))
        for k in range(count)
    ]
    rows = []
    for job in jobs:
        rows.append(judge(job))
        print(json.dumps(rows[-1]), flush=True)
    results = {"trials": rows, "summary": summary(rows)}
    if asked.dry:
        print(table(results["summary"]))
    else:
        keep(FOLDER, results, table(results["summary"]))


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Shares [%] and counts over all trials, and over each kind of cause."""
    outside = [row for row in rows if row["kind"] == "outside"]
    inside = [row for row in rows if row["kind"] == "inside"]
    kinds = {name: [row for row in outside if row["cause"] == name] for name in OUTSIDE}
    return {
        "outside": {name: _outside(group) for name, group in {"all": outside, **kinds}.items() if group},
        "inside": {
            "trials": len(inside),
            "learned_cause": sum(row["learned_cause"] for row in inside),
            "found": sum(row["found"] for row in inside),
        },
    }


def _outside(rows: list[dict[str, Any]]) -> dict[str, Any]:
    curves = [row["curve_percent"] for row in rows if row["curve_percent"] is not None]
    return {
        "trials": len(rows),
        "right": sum(row["right"] for row in rows),
        "learned": sum(row["learned"] for row in rows),
        "wrong_cause": sum(row["wrong_cause"] for row in rows),
        "curves": len(curves),
        "curve_within_15": sum(c <= 15 for c in curves),
        "curve_median": float(np.median(curves)) if curves else None,
        "held_out_within_1.2": sum(row["after"] <= 1.2 * row["oracle"] for row in rows),
        "held_out_median": float(np.median([row["after"] / row["oracle"] for row in rows])),
        "before_median": float(np.median([row["before"] / row["oracle"] for row in rows])),
    }


def table(found: dict[str, Any]) -> str:
    """The table of the README."""
    head = f"{'cause':<16}{'trials':>7}{'right joint, variable':>23}{'learned':>9}{'wrong cause':>13}{'curve < 15 %':>14}{'of oracle < 1.2':>17}{'median':>8}{'before':>8}"
    rows = [head]
    for name, one in found["outside"].items():
        within = f"{one['curve_within_15']} of {one['curves']}"
        rows.append(
            f"{name:<16}{one['trials']:>7}{one['right']:>23}{one['learned']:>9}{one['wrong_cause']:>13}{within:>14}"
            f"{one['held_out_within_1.2']:>17}{one['held_out_median']:>8.2f}{one['before_median']:>8.2f}"
        )
    own = found["inside"]
    rows.append(
        f"\neffects of the catalogue: {own['trials']} trials, a learned cause in {own['learned_cause']}, the effect found in {own['found']}"
    )
    return "\n".join(rows)


if __name__ == "__main__":
    main()
