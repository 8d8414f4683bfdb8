"""Are curves learned where no law is known, on the right joint and of the right variable, and nowhere else?"""

from __future__ import annotations

import argparse
import json
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: one process a core
os.environ.setdefault("OMP_NUM_THREADS", "1")

import sys
from multiprocessing import Pool
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from studies.kept import keep
from studies.learned.causes import OUTSIDE
from studies.learned.trial import judge

FOLDER = Path(__file__).parent
CACHE = Path(os.environ.get("PHYSIDENT_CACHE", Path.home() / ".cache" / "physident")) / "learned"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--outside", type=int, default=60)
    parser.add_argument("--inside", type=int, default=60)
    parser.add_argument(
        "--first", type=int, default=200, help="number of the first trial; those below 200 are for development"
    )
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--resume", action="store_true", help="leave out what was judged before")
    parser.add_argument(
        "--keep", action="store_true", help="write results.json and the README's table, and run nothing"
    )
    asked = parser.parse_args()
    file = CACHE / f"from{asked.first}.jsonl"
    file.parent.mkdir(parents=True, exist_ok=True)
    if not asked.keep:
        _run(asked, file)
    rows = _read(file)
    found = summary(rows)
    if asked.keep:
        keep(FOLDER, {"first": asked.first, "trials": rows, "summary": found}, table(found))
    else:
        print(table(found))


def _run(asked: argparse.Namespace, file: Path) -> None:
    """Judge the trials that are asked for, the kinds in turn, and append a line each."""
    if not asked.resume:
        file.unlink(missing_ok=True)
    done = {(row["kind"], row["number"]) for row in _read(file)}
    counts = {"outside": asked.outside, "inside": asked.inside}
    jobs = [(kind, asked.first + k) for k in range(max(counts.values())) for kind, count in counts.items() if k < count]
    jobs = [job for job in jobs if job not in done]
    with Pool(asked.processes) as pool, file.open("a", encoding="utf-8") as stream:
        for row in pool.imap_unordered(judge, jobs):
            stream.write(json.dumps(row) + "\n")
            stream.flush()
            print(json.dumps(row), flush=True)


def _read(file: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()] if file.exists() else []


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
        "held_out": _held_out(rows, ""),
        "held_out_where_recorded": _held_out(rows, "_where_recorded"),
        "before_median": float(np.median([row["before"] / row["oracle"] for row in rows])),
    }


def _held_out(rows: list[dict[str, Any]], where: str) -> dict[str, Any]:
    """How the held-out error compares with the oracle's."""
    ratios = [row[f"after{where}"] / row[f"oracle{where}"] for row in rows if row[f"after{where}"] is not None]
    return {
        "trials": len(ratios),
        "within_1.2": sum(ratio <= 1.2 for ratio in ratios),
        "median": float(np.median(ratios)) if ratios else None,
    }


def table(found: dict[str, Any]) -> str:
    """The table of the README."""
    head = (
        f"{'cause':<16}{'trials':>7}{'right joint, variable':>23}{'learned':>9}{'wrong cause':>13}{'curve < 15 %':>14}"
        f"{'of oracle < 1.2':>17}{'median':>8}{'where recorded':>16}{'median':>8}{'before':>8}"
    )
    rows = [head]
    for name, one in found["outside"].items():
        everywhere, inside = one["held_out"], one["held_out_where_recorded"]
        within = f"{one['curve_within_15']} of {one['curves']}"
        near = f"{inside['within_1.2']} of {inside['trials']}"
        rows.append(
            f"{name:<16}{one['trials']:>7}{one['right']:>23}{one['learned']:>9}{one['wrong_cause']:>13}{within:>14}"
            f"{everywhere['within_1.2']:>17}{everywhere['median']:>8.2f}{near:>16}{inside['median'] or np.nan:>8.2f}"
            f"{one['before_median']:>8.2f}"
        )
    own = found["inside"]
    rows.append(
        f"\neffects of the catalogue: {own['trials']} trials, a learned cause in {own['learned_cause']}, the effect found in {own['found']}"
    )
    return "\n".join(rows)


if __name__ == "__main__":
    main()
