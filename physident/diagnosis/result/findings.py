"""What a diagnosis returns: findings with their numbers, and everything a report needs."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.question import Question
from physident.diagnosis.result.unexplained import Remainder
from physident.dynamics.model import Model
from physident.estimation.estimate import Estimate
from physident.files import VERSION, write_json
from physident.recordings.signals import Filter

Array = NDArray[np.float64]
SCHEMA = "physident.diagnosis/1"
Verdict = Literal["explained", "partly_explained", "nothing_missing", "unexplained"]


@dataclass(frozen=True)
class Value:
    """A parameter of a finding: its ``value`` in the extended model, the ``change`` from the model that was diagnosed, its
    standard error and 95 % interval, in ``unit``; ``at_end`` where a shape lies at the end of the range that is searched."""

    name: str
    joint: int
    value: float
    change: float
    std: float
    interval95: tuple[float, float]
    unit: str
    at_end: bool = False


@dataclass(frozen=True)
class Reduction:
    """RMS [N m|N] over a finding's joints, noise-weighted, without and with it on rows that were left out, and its
    reduction [%] with a 95 % interval."""

    rms_before: float
    rms_after: float
    reduction_percent: float
    interval95: tuple[float, float]


@dataclass(frozen=True)
class Rival:
    """An effect that could stand in a finding's place as far as these recordings can tell."""

    effect: str
    joints: tuple[int, ...]


@dataclass(frozen=True)
class Finding:
    """A cause: an effect on some joints (from 1; empty: the whole arm), its values, what it gains on rows that were left
    out, what it could be confused with, ``intervals`` (start, end) [s] of a contact and the hash of its ``recording``, and ``advice`` to separate rivals."""

    effect: str
    joints: tuple[int, ...]
    parameters: tuple[Value, ...]
    gain: Reduction
    rivals: tuple[Rival, ...]
    intervals: tuple[tuple[float, float], ...]
    advice: str
    evidence: float  # left-out gain in units of the noise, by which findings are ordered
    recording: str = ""


@dataclass(frozen=True, eq=False)
class Levels:
    """Error of one model: ``rms`` (n,) [N m|N] and ``relative`` (n,) [%]."""

    rms: Array
    relative: Array

    def as_dict(self) -> dict[str, Any]:
        """The error as JSON can hold it."""
        return {"rms": self.rms.tolist(), "relative_percent": self.relative.tolist()}


@dataclass(frozen=True)
class Placebo:
    """A column that cannot be a cause: its left-out gain beside the gate's threshold."""

    name: str
    joint: int
    gain: float
    threshold: float

    @property
    def passed(self) -> bool:
        """Whether the gate let it through, which it must not."""
        return self.gain > self.threshold


@dataclass(frozen=True)
class Unseen:
    """An effect on some joints that these recordings cannot show, and why."""

    effect: str
    joints: tuple[int, ...]
    reason: str


@dataclass(frozen=True)
class Used:
    """A recording and what it was used for: diagnosed or holdout."""

    path: str
    sha256: str
    role: str


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What is wrong with a model, where, how sure, and what it could be confused with.

    ``before``, ``after``: errors on the holdout, or on left-out rows without one (``scored_on``). ``estimate`` is the
    extended model, None where nothing was found. ``held``: base parameters the model never identified. ``incomplete``: joints
    (from 1) on which a model, asked what is different now, left more than noise of its own recordings.
    """

    question: Question
    verdict: Verdict
    findings: tuple[Finding, ...]
    before: Levels
    after: Levels
    scored_on: str
    noise_floor: Array | None
    placebos: tuple[Placebo, ...]
    unseen: tuple[Unseen, ...]
    remainder: tuple[Remainder, ...]
    recordings: tuple[Used, ...]
    model: Model
    estimate: Estimate | None
    filter: Filter
    columns: str | None
    drive_gains: tuple[float, ...] | None
    held: tuple[str, ...]
    seed: int = 0
    incomplete: tuple[int, ...] = ()
    recording_offsets: bool = False

    def as_dict(self) -> dict[str, Any]:
        """The diagnosis as JSON can hold it (schema physident.diagnosis/1)."""
        return {
            "schema": SCHEMA,
            "question": self.question,
            "verdict": self.verdict,
            "findings": [_plain(asdict(f)) for f in self.findings],
            "score": {
                "before": self.before.as_dict(),
                "after": self.after.as_dict(),
                "noise_floor": None if self.noise_floor is None else self.noise_floor.tolist(),
                "on": self.scored_on,
            },
            "placebos": [_plain(asdict(p)) | {"passed": p.passed} for p in self.placebos],
            "unseen": [_plain(asdict(u)) for u in self.unseen],
            "unexplained": [r.as_dict() for r in self.remainder],
            "recordings": [asdict(r) for r in self.recordings],
            "filter": vars(self.filter),
            "columns": self.columns,
            "drive_gains": self.drive_gains and list(self.drive_gains),
            "held": list(self.held),
            "incomplete": list(self.incomplete),
            "recording_offsets": self.recording_offsets,
            "seed": self.seed,
            "version": VERSION,
            "model": self.model.as_dict(),
            "extended_model": None if self.estimate is None else self.estimate.model.as_dict(),
        }

    def save(self, path: str | Path) -> None:
        """Write the diagnosis as JSON, whole or not at all."""
        write_json(path, self.as_dict())

    def __repr__(self) -> str:
        from physident.diagnosis.result.text import diagnosis_text

        return diagnosis_text(self)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(v) for key, v in value.items()}
    return [_plain(v) for v in value] if isinstance(value, tuple | list) else value
