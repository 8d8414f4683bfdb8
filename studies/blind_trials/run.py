"""Are hidden effects named, and are healthy arms left alone? Blind trials on an independent plant."""

from __future__ import annotations

import argparse
import json
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: one process a core

import sys
import time
from dataclasses import asdict
from multiprocessing import Pool
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

import physident as pid
from studies.blind_trials.arms import CACHE, FILTER
from studies.blind_trials.attainable import attainable
from studies.blind_trials.scoring import score
from studies.blind_trials.summary import ASKED, summary, table
from studies.blind_trials.trial import Prepared, prepare

VALUED = ("middle", "strong")
PAIRS_FROM = 5000  # numbers of pairs, so that no motion is shared with a single trial


def diagnose(prepared: Prepared, healthy: bool) -> tuple[pid.Diagnosis, float]:
    """The diagnosis of the changed or the clean recordings, and its processor time [s]."""
    taken = prepared.clean if healthy else prepared.changed
    runs = [t.recording for t in taken[:2]]
    model = prepared.model
    if prepared.trial.question == "missing":
        model = pid.identify(pid.load_robot("ur5"), runs, filter=FILTER)
    begun = time.process_time()
    found = pid.diagnose_motion(model, runs, filter=FILTER if isinstance(model, pid.Model) else None)
    return found, time.process_time() - begun


def judge(job: tuple[int, int, bool]) -> dict[str, Any]:
    """One trial and its clean twin."""
    group, number, pair = job
    prepared = prepare(group, number, pair)
    row = asdict(prepared.trial)
    row |= {"score": asdict(score(prepared, *diagnose(prepared, healthy=False)))}
    if not pair:
        twin, seconds = diagnose(prepared, healthy=True)
        row["twin"] = {
            "found": [[f.effect, list(f.joints)] for f in twin.causes],
            "listed": [[f.effect, list(f.joints)] for f in twin.findings], "verdict": twin.verdict, "seconds": seconds,
            "placebos": sum(p.passed for p in twin.placebos),
        }  # fmt: skip
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--set", type=int, default=1, help="which seeds: 1 and 2 are reported, others are for development"
    )
    parser.add_argument("--trials", type=int, default=340, help="one in ten is of a cell that cannot be seen")
    parser.add_argument("--pairs", type=int, default=100)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--keep", action="store_true", help="write the results of sets 1 and 2 and the table")
    parser.add_argument("--resume", action="store_true", help="judge only what is not in the set's rows yet")
    parser.add_argument("--record", action="store_true", help="only make the recordings")
    asked = parser.parse_args()
    CACHE.mkdir(parents=True, exist_ok=True)
    if asked.keep:
        kept()
        return
    jobs = [(asked.set, n, False) for n in range(asked.trials)]
    jobs += [(asked.set, PAIRS_FROM + n, True) for n in range(asked.pairs)]
    with Pool(asked.processes) as pool:
        if asked.record:
            for _ in pool.imap_unordered(recorded, jobs):
                pass
            return
        rows = read_rows(asked.set) if asked.resume else []
        done = {row["number"] for row in rows}
        with rows_of(asked.set).open("a" if asked.resume else "w", encoding="utf-8") as stream:
            for row in pool.imap_unordered(judge, [job for job in jobs if job[1] not in done]):
                rows.append(row)
                stream.write(json.dumps(row) + "\n")
                stream.flush()
                print(line(row), flush=True)
    print(table({f"set {asked.set}": summary(rows)}))


def recorded(job: tuple[int, int, bool]) -> None:
    """Make the recordings of a trial."""
    prepare(*job)


def chance(job: tuple[int, int, bool]) -> float:
    """How often [%] anybody's value of a trial could be within ten per cent."""
    return attainable(prepare(*job))


def rows_of(group: int) -> Path:
    """Where the rows of a set are."""
    return CACHE / f"set{group}.jsonl"


def read_rows(group: int) -> list[dict[str, Any]]:
    """The rows of a set that were judged, none where there are none."""
    return (
        [json.loads(text) for text in rows_of(group).read_text(encoding="utf-8").splitlines()]
        if rows_of(group).exists()
        else []
    )


def kept() -> None:
    """Write results.json and the README's table from the rows of sets 1 and, where it was run, 2."""
    from studies.kept import keep

    sets = {}
    for group, name in ((1, "first seeds"), (2, "second seeds")):
        rows = read_rows(group)
        if rows:
            valued = [
                (group, r["number"], False) for r in rows if r["tier"] in VALUED and r["score"]["error"] is not None
            ]
            with Pool(2) as pool:
                chances = pool.map(chance, [job for job in valued if job[1] < PAIRS_FROM])
            sets[name] = summary(rows) | {"attainable": float(np.mean(chances))}
    keep(Path(__file__).parent, {"asked": ASKED, "sets": sets}, table(sets))


def line(row: dict[str, Any]) -> str:
    """One trial in one line."""
    truth = "; ".join(f"{h['effect']} {','.join(map(str, h['joints']))}" for h in row["hidden"])
    s, twin = row["score"], row.get("twin", {}).get("found")
    error, gain = (None if s[key] is None else round(s[key], 1) for key in ("error", "gain"))
    return (
        f"{row['number']:5d} {row['question']:9s} {row['tier']:9s} {row['reduction']:5.1f} % {truth}: {s['told']}"
        f" | {_verdict(row)} {s['others']} more, error {error},"
        f" gain {gain}, {s['seconds']:.1f} s" + (f" CLEAN {twin}" if twin else "")
    )


def _verdict(row: dict[str, Any]) -> str:
    s = row["score"]
    if row["tier"] == "invisible" and s["unseen"]:
        return "unseen"
    if s["first"]:
        return "alone" if s["alone"] else "class"
    return "listed" if s["listed"] else "silent" if s["told"] == "nothing" else "WRONG"


if __name__ == "__main__":
    main()
