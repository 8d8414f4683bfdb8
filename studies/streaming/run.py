"""How long does a long recording take, and how much memory? Sizes (rows) and verbs may be given: run.py 200000 1000000 diagnose."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import keep
from recorded import write_recording

SIZES = (200_000, 1_000_000, 5_000_000)  # rows
VERBS = ("identify", "validate", "inspect", "payload", "diagnose")
COMPARED = 1_000_000  # rows of which all is also computed in memory, by one process
LOAD = 3.0  # kg
# one call in a process of its own, whose memory is its own; PHYSIDENT_LARGE is a limit that only this study sets
CALL = """
import json, resource, sys, time, warnings
warnings.simplefilter("ignore")
import numpy as np
import physident as pid
from physident import large_arrays
verb, path, model, limit = sys.argv[1:]
if limit != "usual":
    large_arrays.LARGE.set(int(limit))
    large_arrays.BLOCK = 1 << 40
begun = time.perf_counter(), time.process_time()
if verb == "identify":
    pid.identify("ur10e", path).save(model)
elif verb == "diagnose":
    pid.diagnose_motion(pid.load_estimate(model), path)
elif verb == "validate":
    pid.validate(pid.load_estimate(model), path, include_fitted=True)
elif verb == "payload":
    pid.identify_payload(pid.load_estimate(model), path)
else:
    from physident.recordings.inspection import inspect_recording
    from physident.recordings.load import load_recording
    inspect_recording(load_recording(path))
own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
print(json.dumps({
    "elapsed_s": time.perf_counter() - begun[0],
    "processor_s": own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime,
    "memory_GB": own.ru_maxrss / 1e6, "helper_memory_GB": children.ru_maxrss / 1e6,
}))
"""


def main() -> None:
    sizes = [int(word) for word in sys.argv[1:] if word.isdigit()] or list(SIZES)
    verbs = [word for word in sys.argv[1:] if not word.isdigit()] or list(VERBS)
    here = Path(__file__).parent
    kept = here / "results.json"
    results: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    for rows in sizes:
        with tempfile.TemporaryDirectory() as name:
            results[str(rows)] = {**results.get(str(rows), {}), **measured(Path(name), rows, verbs)}
    keep(here, dict(sorted(results.items(), key=lambda item: int(item[0]))), table(results))


def measured(folder: Path, rows: int, verbs: Sequence[str]) -> dict[str, Any]:
    """Time and memory of some verbs on a recording of some rows."""
    path, model = folder / "run.parquet", folder / "model.json"
    write_recording(path, rows)
    found: dict[str, Any] = {}
    identified = call("identify", path, model)  # the others need the model
    if "identify" in verbs:
        found["identify"] = identified
    if rows == COMPARED and "identify" in verbs:
        for label, processes, limit in (("one process", 1, "usual"), ("in memory", 1, str(1 << 40))):
            other = folder / f"{processes}_{limit}.json"
            found[f"identify, {label}"] = call("identify", path, other, processes, limit)
            found[f"identify, {label}"]["difference"] = difference(model, other)
    for verb in ("validate", "inspect", "diagnose"):
        if verb in verbs and (rows <= COMPARED or verb == "diagnose"):
            found[verb] = call(verb, path, model)
    if "payload" in verbs and rows <= COMPARED:
        write_recording(path, rows, seed=1, load=LOAD)
        found["payload"] = call("payload", path, model)
    return found


def call(verb: str, path: Path, model: Path, processes: int | None = None, limit: str = "usual") -> dict[str, Any]:
    """One verb in a process of its own."""
    given = {} if processes is None else {"PHYSIDENT_PROCESSES": str(processes)}
    command = [sys.executable, "-c", CALL, verb, str(path), str(model), limit]
    done = subprocess.run(command, env={**os.environ, **given}, capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def difference(one: Path, other: Path) -> float:
    """Largest difference of two models' parameters, over the size of the largest."""
    values = [
        [parameter["value"] for parameter in json.loads(path.read_text(encoding="utf-8"))["parameters"]]
        for path in (one, other)
    ]
    size = max(map(abs, values[0]))
    return max(abs(a - b) for a, b in zip(*values, strict=True)) / size


def table(results: dict[str, Any]) -> str:
    """The table of all sizes."""
    lines = [
        f"{'':<26}{'rows':>12}{'elapsed s':>11}{'processor s':>13}{'us a row':>10}{'memory GB':>11}{'helper GB':>11}{'difference':>12}"
    ]
    for rows, verbs in sorted(results.items(), key=lambda item: int(item[0])):
        for verb, r in verbs.items():
            apart = f"{r['difference']:.0e}" if "difference" in r else ""
            lines.append(
                f"{verb:<26}{int(rows):>12,}{r['elapsed_s']:>11.0f}{r['processor_s']:>13.0f}{1e6 * r['processor_s'] / int(rows):>10.1f}"
                f"{r['memory_GB']:>11.2f}{r['helper_memory_GB']:>11.2f}{apart:>12}"
            )
    return "\n".join(lines)


if __name__ == "__main__":
    main()
