"""Does a diagnosis name the right cause in a world that its author did not make, and does it know when it cannot?"""

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

from studies.open_world.bench import CACHE
from studies.open_world.judge import Job, judge, line
from studies.open_world.overview import every_set, overview
from studies.open_world.pooled import pooled
from studies.open_world.summary import summary, table
from studies.open_world.trial import FROM, Kind

NAMES = {
    "first": "First world",
    "again": "First world, motions repeated",
    "second": "Second world, drawn by other code",
}
SHORT_NAMES = {"again": "motions repeated", "first": "first world", "second": "second world"}
TABLES = """# Open world: all tables

Written by `python -m studies.open_world.run --keep`; [the study](README.md) explains them. First every set that was kept, by the
rules of the day on which it was run; then the sets that the study reports, by everything that was drawn.

"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--world", choices=("first", "again", "second"), default="first")
    parser.add_argument("--set", type=int, default=1, help="which seeds; 1 is reported, others are for development")
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--pairs", type=int, default=0)
    parser.add_argument("--outside", type=int, default=0)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--resume", action="store_true", help="leave out what is in the file of results already")
    parser.add_argument(
        "--only", nargs="*", default=[], metavar="KIND:NUMBER", help="of these trials, as pair:3, only some"
    )
    parser.add_argument(
        "--keep",
        nargs="+",
        type=int,
        metavar="SET",
        help="write results.json, tables.md and the README's table, and run nothing",
    )
    parser.add_argument(
        "--add", action="store_true", help="to --keep: pool these sets with those that are kept of their world"
    )
    asked = parser.parse_args()
    if asked.add and not asked.keep:
        parser.error("--add goes with --keep, which names the sets to pool")
    rows_file = CACHE / asked.world / f"set{asked.set}.jsonl"
    rows_file.parent.mkdir(parents=True, exist_ok=True)
    if asked.keep:
        _kept(asked.keep, asked.add)
        return
    if not asked.resume and not asked.only:
        rows_file.unlink(missing_ok=True)
    print(table(summary(_run(asked, rows_file))))


def _run(asked: argparse.Namespace, rows_file: Path) -> list[dict[str, Any]]:
    """Judge the trials that are asked for, append a line each, and return all rows of the file."""
    counts: dict[Kind, int] = {"single": asked.trials, "pair": asked.pairs, "outside": asked.outside}
    jobs: list[Job] = [(asked.world, asked.set, kind, n) for kind, count in counts.items() for n in range(count)]
    if asked.only:
        jobs = [job for job in jobs if f"{job[2]}:{job[3]}" in asked.only]
    done = {(r["kind"], r["number"]) for r in _read(rows_file)} if asked.resume else set()
    jobs = [job for job in jobs if (job[2], FROM[job[2]] + job[3]) not in done]
    with Pool(asked.processes) as pool, rows_file.open("a", encoding="utf-8") as stream:
        for count, row in enumerate(pool.imap_unordered(judge, jobs), 1):
            stream.write(json.dumps(row) + "\n")
            stream.flush()
            print(f"{count}/{len(jobs)} {line(row)}", flush=True)
    return _read(rows_file)


def _kept(groups: list[int], add: bool) -> None:
    """Write results.json, tables.md and the README's table from all of some sets that were run of each world, pooled with what is kept where they
    ``add`` to it; a world of which there are no rows keeps its results."""
    from studies.kept import keep

    before = json.loads((Path(__file__).parent / "results.json").read_text(encoding="utf-8"))
    worlds, alone, texts = dict(before["worlds"]), dict(before["figures_of_each_set"]), []
    sets = before.get("sets") or {world: list(each) for world, each in alone.items()}
    for world, name in NAMES.items():
        rows = {str(group): _read(CACHE / world / f"set{group}.jsonl") for group in groups}
        rows = {group: some for group, some in rows.items() if some}
        if add and (again := set(rows) & set(sets.get(world, ()))):
            raise SystemExit(f"set {', '.join(sorted(again))} of {name} is kept already: --keep without --add")
        if rows:
            new = summary([row for some in rows.values() for row in some])
            worlds[world] = pooled(worlds[world], new) if add and world in worlds else new
            sets[world] = [*sets.get(world, []), *rows] if add else list(rows)
            alone[world] = {**alone.get(world, {}), **{group: summary(some)["figures"] for group, some in rows.items()}}
        if world in worlds:
            texts.append(f"{name}, set {', '.join(sets[world])}\n\n{table(worlds[world])}")
    tables = "\n\n".join(f"```\n{text}\n```" for text in (every_set(alone, NAMES), *texts))
    (Path(__file__).parent / "tables.md").write_text(TABLES + tables + "\n", encoding="utf-8")
    headings = {world: f"{name} ({_in_short(sets[world])})" for world, name in SHORT_NAMES.items() if world in sets}
    results = {"worlds": worlds, "sets": sets, "figures_of_each_set": alone}
    keep(Path(__file__).parent, results, overview(worlds, headings))


def _in_short(sets: list[str]) -> str:
    """Three sets or more in a row by the first and the last."""
    rows: list[list[int]] = []
    for number in map(int, sets):
        if rows and number == rows[-1][-1] + 1:
            rows[-1].append(number)
        else:
            rows.append([number])
    return ", ".join(f"{row[0]} to {row[-1]}" if len(row) > 2 else ", ".join(map(str, row)) for row in rows)


def _read(path: Path) -> list[dict[str, Any]]:
    """All rows of a file, the last one of each trial."""
    if not path.exists():
        return []
    rows = [json.loads(text) for text in path.read_text(encoding="utf-8").splitlines()]
    return list({(r["kind"], r["number"]): r for r in rows}.values())


if __name__ == "__main__":
    main()
