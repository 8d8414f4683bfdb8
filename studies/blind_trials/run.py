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

import physident as pid
from studies.blind_trials.arms import CACHE
from studies.blind_trials.scoring import score
from studies.blind_trials.trial import Prepared, prepare

PAIRS_FROM = 5000  # numbers of pairs, so that no motion is shared with a single trial


def diagnose(prepared: Prepared, healthy: bool) -> tuple[pid.Diagnosis, float]:
    """The diagnosis of the changed or the clean recordings, and its processor time [s]."""
    taken = prepared.clean if healthy else prepared.changed
    runs = [t.recording for t in taken[:2]]
    model = prepared.model
    if prepared.trial.question == "missing":
        model = pid.identify(pid.load_robot("ur5"), runs)
    begun = time.process_time()
    found = pid.diagnose(model, runs)
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
            "found": [[f.effect, list(f.joints)] for f in twin.findings], "verdict": twin.verdict, "seconds": seconds,
            "placebos": sum(p.passed for p in twin.placebos),
        }  # fmt: skip
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--set", type=int, default=1, help="which seeds; 0 is for development")
    parser.add_argument("--trials", type=int, default=340)
    parser.add_argument("--pairs", type=int, default=100)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    asked = parser.parse_args()
    jobs = [(asked.set, n, False) for n in range(asked.start, asked.start + asked.trials)]
    jobs += [(asked.set, PAIRS_FROM + n, True) for n in range(asked.start, asked.start + asked.pairs)]
    rows = []
    CACHE.mkdir(parents=True, exist_ok=True)
    with Pool(asked.processes) as pool, (CACHE / f"set{asked.set}.jsonl").open("w", encoding="utf-8") as stream:
        for row in pool.imap_unordered(judge, jobs):
            rows.append(row)
            stream.write(json.dumps(row) + "\n")
            stream.flush()
            truth = "; ".join(f"{h['effect']} {','.join(map(str, h['joints']))}" for h in row["hidden"])
            s = row["score"]
            twin = row.get("twin", {}).get("found")
            print(
                f"{row['number']:5d} {row['question']:9s} {row['tier']:9s} {row['reduction']:5.1f} % {truth}: {s['told']}"
                f" | {'alone' if s['alone'] else 'class' if s['first'] else 'WRONG'} {s['others']} more, error"
                f" {s['error'] if s['error'] is None else round(s['error'], 1)}, gain"
                f" {s['gain'] if s['gain'] is None else round(s['gain'])}, {s['seconds']:.1f} s"
                + (f" CLEAN {twin}" if twin else ""),
                flush=True,
            )


if __name__ == "__main__":
    main()
