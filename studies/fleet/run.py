"""Forty arms over two years: are the five that degrade named, with cause and joint, within a month of crossing a tenth?

Offsets of all seeds may be given: run.py 0 5000.
"""

from __future__ import annotations

import json
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from datetime import timedelta
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cases import START, Case, write_fleet
from kept import keep
from plant import urdf

from physident.fleet.dataset import read_rows
from physident.fleet.drift.alarms import Alarm, find_drift
from physident.fleet.run import run_fleet

MONTH = 30  # days
SOME = "arm_1[0-3]"  # of the arms, for times
SEEN = 0  # offset of the seeds that were looked at while the method was built


def main() -> None:
    here = Path(__file__).parent
    kept = here / "results.json"
    results: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    for offset in [int(word) for word in sys.argv[1:]] or [SEEN]:
        results[str(offset)] = studied(offset)
        keep(here, results, table(results))


def studied(offset: int) -> dict[str, Any]:
    """What is found in the fleet of an offset of all seeds."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "arm.urdf").write_text(urdf(), encoding="utf-8")
        cases = write_fleet(folder / "runs", offset)
        broken = folder / "runs" / "arm_00" / "2026-01-01.parquet"
        broken.write_bytes(b"PAR1 and no more")
        killed = fleet(folder, 2, "*", kill=True)
        times = timed(folder) if offset == SEEN else {}
        begun = time.perf_counter()
        drift = find_drift(folder / "whole")
        searched = time.perf_counter() - begun
        again = time.perf_counter()
        known = run_fleet(folder / "arm.urdf", [str(folder / "runs/*/*.parquet")], "{robot}/{date}", folder / "whole")
        again = time.perf_counter() - again
        then = [
            find_drift(folder / "whole", until=START + timedelta(days=case.crossing + MONTH)).alarms for case in cases
        ]
    alarms = {alarm.arm: alarm for alarm in drift.alarms}
    degrading = {f"arm_{case.arm:02d}" for case in cases}
    return {
        "arms": len(drift.arms), "recordings": known.known - known.new, "broken": len(drift.broken),
        "false_alarms_per_arm_and_year": drift.rate,
        "false_alarms": [
            {"arm": arm, "named": str(alarm.day), "cause": alarm.words, "strength": alarm.strength, "limit": alarm.limit}
            for arm, alarm in alarms.items() if arm not in degrading
        ],
        "cases": [
            {**judged(case, alarms.get(f"arm_{case.arm:02d}")), "cause_then": cause_of(case, one)}
            for case, one in zip(cases, then, strict=True)
        ],
        **times, "whole_two_workers_one_killed_s": killed, "drift_s": searched, "nothing_new_s": again,
        "new_when_run_again": known.new,
    }  # fmt: skip


def timed(folder: Path) -> dict[str, Any]:
    """Times of one and of two workers on some of the arms, whose numbers must be those of the whole fleet."""
    seconds = {workers: fleet(folder, workers, SOME, kill=False) for workers in (1, 2)}
    some = figures(folder / "out_1")
    arms = {row[0] for row in some}
    same = some == figures(folder / "out_2") == [row for row in figures(folder / "whole") if row[0] in arms]
    return {"some_one_worker_s": seconds[1], "some_two_workers_s": seconds[2], "same_numbers": same}


def table(results: dict[str, Any]) -> str:
    """The tables of all offsets."""
    return "\n\n".join(
        "\n".join(_rows(int(offset), one)) for offset, one in sorted(results.items(), key=lambda item: int(item[0]))
    )


def _rows(offset: int, r: dict[str, Any]) -> list[str]:
    rows = [
        f"seeds {offset:+d}"
        + ", "
        + r.get("method", "looked at while the method was built" if offset == SEEN else "not looked at before"),
        f"{'arm':<8}{'what degrades':<46}{'a tenth on':<12}{'named on':<12}{'days':>5}  {'cause named'}",
    ]
    rows += [
        f"{one['arm']:<8}{one['truth']:<46}{one['crossing']:<12}{one['named'] or '-':<12}{one['days'] if one['days'] is not None else '-':>5}"
        f"  {one['cause'] or '-'}"
        for one in r["cases"]
    ]
    if all("cause_then" in one for one in r["cases"]):
        then = sum(1 for one in r["cases"] if one["cause_then"] == one["cause"] and one["right"])
        rows.append(f"named right from the recordings up to a month after the tenth alone: {then} of 5")
    right, soon = (sum(1 for one in r["cases"] if one[key]) for key in ("right", "in_time"))
    rows += [
        f"right cause and joint: {right} of 5; within a month: {soon} of 5; false alarms among the other 35:"
        f" {len(r['false_alarms'])} (allowed: {r['false_alarms_per_arm_and_year']:g} for each arm and year)",
        f"{r['recordings']:,} recordings by two workers, one of which is killed: {r['whole_two_workers_one_killed_s']:.0f} s;"
        f" drift: {r['drift_s']:.0f} s; run again with nothing new: {r['nothing_new_s']:.0f} s; broken files listed: {r['broken']} of 1",
    ]
    if "same_numbers" in r:
        rows.append(
            f"100 of them by one worker {r['some_one_worker_s']:.0f} s, by two {r['some_two_workers_s']:.0f} s;"
            f" the same numbers: {'yes' if r['same_numbers'] else 'no'}"
        )
    return rows


def fleet(folder: Path, workers: int, arms: str, kill: bool) -> float:
    """Wall time [s] of some arms of a fleet from nothing; with ``kill``, a worker is killed after a third of the files."""
    out = folder / ("whole" if kill else f"out_{workers}")
    done = threading.Event()

    def watch(finished: int, count: int) -> None:
        if kill and finished > count / 3 and not done.is_set():
            done.set()
            kill_a_worker()

    begun = time.perf_counter()
    paths = [str(folder / f"runs/{arms}/*.parquet")]
    run_fleet(folder / "arm.urdf", paths, "{robot}/{date}", out, workers=workers, done=watch)
    return time.perf_counter() - begun


def kill_a_worker() -> None:
    """End one of the cluster's processes from outside, as a machine that fails does."""
    import psutil

    workers = [p for p in psutil.Process().children(recursive=True) if "spawn_main" in " ".join(p.cmdline())]
    workers[0].kill()


def figures(out: Path) -> list[tuple]:
    """What a fleet has found, without the folder it lies in."""
    return [(row["arm"], row["day"], row["parameter"], row["value"], row["std"]) for row in read_rows(out)]


def cause_of(case: Case, alarms: Sequence[Alarm]) -> str | None:
    """The cause that some alarms name for an arm."""
    return next((alarm.words for alarm in alarms if alarm.arm == f"arm_{case.arm:02d}"), None)


def judged(case: Case, alarm: Alarm | None) -> dict:
    """Whether an arm that degrades was named, and when."""
    crossing = START + timedelta(days=case.crossing)
    truth = case.cause if case.joint or case.cause == "payload" else f"{case.cause} of the base"
    named = None if alarm is None else alarm.day
    days = None if named is None else (named - crossing).days
    right = alarm is not None and case.cause in alarm.words
    return {
        "arm": f"arm_{case.arm:02d}", "truth": truth, "crossing": str(crossing), "named": named and str(named),
        "days": days, "cause": alarm and alarm.words, "right": right,
        "in_time": bool(right and days is not None and days <= MONTH), "rivals": list(alarm.rivals) if alarm else [],
    }  # fmt: skip


if __name__ == "__main__":
    main()
