"""What does a planned session save? Hidden arms until all is named, and a real pool of recordings in the order of the plan."""

from __future__ import annotations

import argparse
import json
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: one process a core
os.environ.setdefault("OMP_NUM_THREADS", "1")

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from studies.active.loop import SESSIONS, WAYS, Way, run_arm
from studies.active.real import rank_real_runs, table_of
from studies.kept import keep
from studies.open_world.bench import CACHE

HERE = Path(__file__).parent
ROWS = CACHE / "active" / "rows.jsonl"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--part", choices=("loop", "real", "both"), default="both")
    parser.add_argument("--arms", type=int, default=40, help="how many hidden arms")
    parser.add_argument("--from", type=int, default=0, dest="first", help="the first arm")
    parser.add_argument("--ways", nargs="*", choices=WAYS, default=WAYS, help="these ways only")
    parser.add_argument("--only", type=int, nargs="*", help="these hidden arms, in this order")
    parser.add_argument("--resume", action="store_true", help="leave out what is in the file of rows already")
    parser.add_argument("--keep", action="store_true", help="write results.json and the README's table, and run no arm")
    asked = parser.parse_args()
    if asked.part in ("loop", "both") and not asked.keep:
        _run(asked.only or range(asked.first, asked.first + asked.arms), asked.ways, asked.resume)
    results = json.loads((HERE / "results.json").read_text()) if (HERE / "results.json").exists() else {}
    if asked.part in ("real", "both"):
        results["real"] = rank_real_runs()
    if rows := _read():
        results["loop"] = {"sessions": SESSIONS, "rows": rows, "summary": summary(rows)}
    parts = [loop_table(results["loop"]["summary"])] if "loop" in results else []
    parts += [table_of(results["real"])] if "real" in results else []
    keep(HERE, results, "\n\n".join(parts))


def _run(arms: Iterable[int], ways: Sequence[Way], resume: bool) -> None:
    """Run each arm in each way, and append a line for each."""
    ROWS.parent.mkdir(parents=True, exist_ok=True)
    if not resume:
        ROWS.unlink(missing_ok=True)
    done = {(row["arm"], row["way"]) for row in _read()}
    for index in arms:
        for way in ways:
            if (index, way) in done:
                continue
            row = run_arm(index, way)
            with ROWS.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(row) + "\n")
            told = row.get("refused") or f"{row['minutes']} min, false {row['false']}"
            print(
                f"arm {index} {way}: {[h['effect'] for h in row.get('hidden', [])]} {told} ({row['seconds']:.0f} s)",
                flush=True,
            )


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Minutes of each way over the arms that the planned and the random way were run on; an arm that is not named within the sessions
    counts as one more. The designed motion was run on some of them, None elsewhere."""
    by = {(r["arm"], r["way"]): r for r in rows}
    both = [i for i in sorted({r["arm"] for r in rows}) if (i, "planned") in by and (i, "random") in by]
    judged = [i for i in both if not any("refused" in by.get((i, way), {}) for way in WAYS)]
    minutes = {
        way: [(by[i, way]["minutes"] or SESSIONS + 1) if (i, way) in by else None for i in judged] for way in WAYS
    }
    ran = {way: [m for m in values if m is not None] for way, values in minutes.items()}
    ratio = [p / r for p, r in zip(minutes["planned"], minutes["random"], strict=True)]  # type: ignore[operator]
    return {
        "arms": len(judged),
        "refused": len(both) - len(judged),
        "minutes": minutes,
        "ran": {way: len(values) for way, values in ran.items()},
        "median": {way: float(np.median(values)) if values else None for way, values in ran.items()},
        "mean": {way: float(np.mean(values)) if values else None for way, values in ran.items()},
        "named_first": {way: int(sum(v == 1 for v in values)) for way, values in ran.items()},
        "named_within": {way: int(sum(v <= SESSIONS for v in values)) for way, values in ran.items()},
        "effects": {way: _effects(by, judged, way) for way in WAYS},
        "median_ratio_planned_to_random": float(np.median(ratio)) if ratio else None,
        "arms_where_planned_needs_less": int(sum(r < 1 for r in ratio)),
        "arms_where_planned_needs_more_than_random": int(sum(r > 1 for r in ratio)),
        "arms_with_a_false_cause": {
            way: int(sum(bool(by[i, way]["false"]) for i in judged if (i, way) in by)) for way in WAYS
        },
    }


def _effects(by: dict[tuple[int, str], dict[str, Any]], arms: list[int], way: str) -> tuple[int, int]:
    """How many hidden effects a way has named by its end, and of how many."""
    ends = [by[i, way]["history"][-1]["right"] for i in arms if (i, way) in by]
    return sum(sum(end) for end in ends), sum(map(len, ends))


def loop_table(found: dict[str, Any]) -> str:
    """The table of the closed loop."""
    rows = [
        f"closed loop, {found['arms']} hidden arms, at most {SESSIONS} sessions of one minute (one more where not named by then)",
        f"{'way':<10}{'arms':>5}{'median':>8}{'mean':>6}{'after 1':>9}{'within 4':>10}{'effects':>12}{'a false cause':>15}   minutes of each arm",
    ]
    for way in WAYS:
        values = " ".join("-" if v is None else f"{v:g}" for v in found["minutes"][way])
        named, of = found["effects"][way]
        rows.append(
            f"{way:<10}{found['ran'][way]:5d}{found['median'][way] or 0:8.1f}{found['mean'][way] or 0:6.1f}{found['named_first'][way]:9d}"
            f"{found['named_within'][way]:10d}{named:6d} of {of:<3d}{found['arms_with_a_false_cause'][way]:14d}    {values}"
        )
    if found["median_ratio_planned_to_random"] is not None:
        medians = found["median"]["planned"] / found["median"]["random"]
        rows.append(
            f"planned needs {medians:.2f} of random's minutes by the medians, {found['median_ratio_planned_to_random']:.2f} in the median of"
            f" the ratios, less on {found['arms_where_planned_needs_less']} arms and more on {found['arms_where_planned_needs_more_than_random']}"
        )
    return "\n".join(rows)


def _read() -> list[dict[str, Any]]:
    """All rows so far, the last one of each arm and way."""
    if not ROWS.exists():
        return []
    rows = [json.loads(text) for text in ROWS.read_text(encoding="utf-8").splitlines()]
    return list({(r["arm"], r["way"]): r for r in rows}.values())


if __name__ == "__main__":
    main()
