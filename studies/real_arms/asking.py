"""What every part shares: the command line as a user types it, and what is kept of its answer."""

from __future__ import annotations

import contextlib
import io
import json
import re
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import DATA, UR5_GAINS, UR10E_COLUMNS, UR10E_GAINS

from physident.cli import run

HERE = Path(__file__).parent
UR10E = ("--columns", UR10E_COLUMNS, "--drive-gains", " ".join(map(str, UR10E_GAINS)))
UR5 = ("--drive-gains", " ".join(map(str, UR5_GAINS)), "--cutoff", "8")
ENDS = "unexplained"  # how the rows after the findings begin


def ask(*arguments: object) -> str:
    """Run one command and return what it prints; the study ends where the command does not succeed."""
    words = [str(a) for a in arguments]
    said, warned = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(warned):
        code = run(words)
    if code:
        sys.exit(f"physident {' '.join(words)}: exit code {code}\n{warned.getvalue()}")
    return re.sub(rf"{re.escape(tempfile.gettempdir())}/[^/\s]+/", "", said.getvalue())  # the study's own folder


def diagnose(work: Path, name: str, model: Path, recordings: Iterable[Path], *options: object) -> dict[str, Any]:
    """The JSON of ``physident diagnose``, with the printed ``text``; the extended model is NAME_extended.json."""
    target = work / f"{name}.json"
    text = ask(
        "diagnose", "--model", model, *recordings, "--json", target, "--out", work / f"{name}_extended.json", *options
    )
    return json.loads(target.read_text(encoding="utf-8")) | {"text": text}


def brief(found: dict[str, Any]) -> dict[str, Any]:
    """What results.json keeps of a diagnosis."""
    return {
        "question": found["question"],
        "verdict": found["verdict"],
        "findings": [
            {k: f[k] for k in ("effect", "joints", "grade", "takes_percent", "leaves_percent", "stability", "gain", "intervals")}
            | {"parameters": [{k: p[k] for k in ("name", "joint", "value", "interval95", "unit")} for p in f["parameters"]]}
            | {"rivals": [[r["effect"], r["joints"]] for r in f["rivals"]]}
            for f in found["findings"]
        ],
        "before_percent": found["score"]["before"]["relative_percent_all"],
        "after_percent": found["score"]["after"]["relative_percent_all"],
        "scored_on": found["score"]["on"],
        "placebos": [len(found["placebos"]), sum(p["passed"] for p in found["placebos"])],
        "unexplained": [
            {k: r[k] for k in ("joint", "rms", "memory", "slow", "structured")} for r in found["unexplained"]
        ],
    }  # fmt: skip


def named(found: dict[str, Any]) -> str:
    """The causes' names and joints in one line."""
    causes = [f for f in found["findings"] if f["grade"] == "cause"]
    texts = [f"{f['effect']}{' ' + ', '.join(map(str, f['joints'])) if f['joints'] else ''}" for f in causes]
    return "; ".join(texts) or "nothing"


def shown(found: dict[str, Any]) -> list[str]:
    """The printed answer up to its findings, and the check of the placebos."""
    rows = found["text"].splitlines()
    end = next((k for k, row in enumerate(rows) if row.startswith(ENDS)), len(rows))
    return [*rows[:end], *(row for row in rows if row.startswith("placebos"))]


def parameter(found: dict[str, Any], effect: str, name: str) -> dict[str, Any] | None:
    """A parameter of a finding by name, or None where it was not found."""
    every = [p for f in found["findings"] if f["effect"] == effect for p in f["parameters"] if p["name"] == name]
    return every[0] if every else None


def percent(values: Sequence[float]) -> str:
    """Errors of the joints in one line."""
    return " ".join(f"{v:.1f}" for v in values)


def paths(folder: str, *names: str) -> list[Path]:
    """Recordings of an arm by file name or pattern."""
    return [path for name in names for path in sorted((DATA / folder).glob(name))]


def february(work: Path) -> tuple[Path, Path, dict[str, Any]]:
    """The UR10e of the eight February runs: its default model, the one that diagnosis makes of it, and the diagnosis."""
    model, extended, kept = work / "ur10e.json", work / "ur10e_missing_extended.json", work / "ur10e_answer.json"
    if not kept.exists():
        runs = paths("ur10e", "ur-20_02_*.csv")
        ask("identify", *runs, "--robot", DATA / "ur10e" / "ur10e.urdf", *UR10E, "--out", model)
        kept.write_text(json.dumps(diagnose(work, "ur10e_missing", model, runs)), encoding="utf-8")
    return model, extended, json.loads(kept.read_text(encoding="utf-8"))
