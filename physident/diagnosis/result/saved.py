"""What a diagnosis file says, read back and checked: all that a report is made of."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from physident.diagnosis.problem.question import Question
from physident.diagnosis.result.findings import SCHEMA, Diagnosis, Finding, Levels, Placebo, Unseen, Used, Verdict
from physident.diagnosis.result.unexplained import Remainder
from physident.dynamics.model import Model
from physident.effects.catalogue import CATALOGUE
from physident.errors import InputError
from physident.files import naming, read_json
from physident.json_records import RecordReader
from physident.recordings.signals import Filter

MAX_BYTES = 200_000_000  # of a diagnosis file
READER = RecordReader("diagnose again")
EXPECTED = "a diagnosis of motions that physident diagnose --json wrote"


@dataclass(frozen=True, eq=False)
class Contents:
    """A diagnosis as its file holds it; see ``Diagnosis``. ``extended`` is the extended model, None where nothing was
    found; ``path`` and ``sha256`` are those of the file, None for a diagnosis in memory."""

    path: Path | None
    sha256: str | None
    question: Question
    verdict: Verdict
    findings: tuple[Finding, ...]
    before: Levels
    after: Levels
    scored_on: str
    noise_floor: tuple[float, ...] | None
    placebos: tuple[Placebo, ...]
    unseen: tuple[Unseen, ...]
    remainder: tuple[Remainder, ...]
    recordings: tuple[Used, ...]
    filter: Filter
    columns: str | None
    drive_gains: tuple[float, ...] | None
    held: tuple[str, ...]
    incomplete: tuple[int, ...]
    seed: int
    recording_offsets: bool
    model: Model
    extended: Model | None

    @property
    def structured(self) -> tuple[Remainder, ...]:
        """The joints on which something remains that is no noise, by the verdict."""
        if self.verdict in ("explained", "nothing_missing"):
            return ()
        floor = self.noise_floor or (0.0,) * self.model.robot.n
        return tuple(r for r in self.remainder if r.structured and r.rms > floor[r.joint - 1])

    def shown(self, path: str) -> str:
        """A recording's name without its folders, where that tells it from the others."""
        names = [Path(used.path).name for used in self.recordings]
        return Path(path).name if names.count(Path(path).name) == 1 else path


def contents_of(diagnosis: Diagnosis) -> Contents:
    """The contents of a diagnosis in memory."""
    return _parsed(json.loads(json.dumps(diagnosis.as_dict())), None, None)


def read_contents(path: str | Path) -> Contents:
    """The contents of a diagnosis file; raises InputError where it is missing, no JSON, of another schema, or incomplete."""
    data = read_json(path, MAX_BYTES, EXPECTED, SCHEMA)
    with naming(path, "diagnosis", "diagnose again"):
        return _parsed(data, Path(path), hashlib.sha256(Path(path).read_bytes()).hexdigest())


def _parsed(data: dict[str, Any], path: Path | None, sha256: str | None) -> Contents:
    score = data["score"]
    contents = Contents(
        path=path,
        sha256=sha256,
        question=READER.read(Question, data["question"], "question"),
        verdict=READER.read(Verdict, data["verdict"], "verdict"),
        findings=READER.read(tuple[Finding, ...], data["findings"], "findings"),
        before=_levels(score["before"], "score.before"),
        after=_levels(score["after"], "score.after"),
        scored_on=READER.read(str, score["on"], "score.on"),
        noise_floor=READER.read(tuple[float, ...] | None, score["noise_floor"], "score.noise_floor"),
        placebos=READER.read(tuple[Placebo, ...], data["placebos"], "placebos"),
        unseen=READER.read(tuple[Unseen, ...], data["unseen"], "unseen"),
        remainder=READER.read(tuple[Remainder, ...], data["unexplained"], "unexplained"),
        recordings=READER.read(tuple[Used, ...], data["recordings"], "recordings"),
        filter=Filter(**data["filter"]),
        columns=READER.read(str | None, data["columns"], "columns"),
        drive_gains=READER.read(tuple[float, ...] | None, data["drive_gains"], "drive_gains"),
        held=READER.read(tuple[str, ...], data["held"], "held"),
        incomplete=READER.read(tuple[int, ...], data["incomplete"], "incomplete"),
        seed=READER.read(int, data["seed"], "seed"),
        recording_offsets=READER.read(bool, data["recording_offsets"], "recording_offsets"),
        model=Model.from_dict(data["model"]),
        extended=None if data["extended_model"] is None else Model.from_dict(data["extended_model"]),
    )
    _check(contents)
    return contents


def _levels(data: dict[str, Any], where: str) -> Levels:
    values = (READER.read(tuple[float, ...], data[key], f"{where}.{key}") for key in ("rms", "relative_percent"))
    return Levels(*(np.array(v) for v in values))


def _check(c: Contents) -> None:
    """Raises InputError where the parts do not fit one another, as in a file edited by hand."""
    n = c.model.robot.n
    for name, level in (("score.before", c.before), ("score.after", c.after)):
        if len(level.rms) != n or len(level.relative) != n:
            raise InputError(f"{name} has {len(level.rms)} joints, expected the robot's {n}")
        if min(*level.rms, *level.relative) < 0:
            raise InputError(f"{name} has a negative error; expected sizes")
    if c.noise_floor is not None and len(c.noise_floor) != n:
        raise InputError(f"score.noise_floor has {len(c.noise_floor)} joints, expected the robot's {n}")
    if c.extended is not None and c.extended.robot.n != n:
        raise InputError(f"the extended model has {c.extended.robot.n} joints, the model {n}; expected one robot")
    for effect in [*(f.effect for f in c.findings), *(r.effect for f in c.findings for r in f.rivals)]:
        if effect not in CATALOGUE:
            raise InputError(f"effect {effect!r} is not in the catalogue; expected a diagnosis of this version")
    joints = [j for one in (*c.findings, *c.unseen) for j in one.joints]
    if wrong := [j for j in (*joints, *c.incomplete, *(r.joint for r in c.remainder)) if not 1 <= j <= n]:
        raise InputError(f"joint {wrong[0]} is named, expected 1 to {n}")
    named = c.verdict in ("explained", "partly_explained")
    if bool(c.findings) != (c.extended is not None) or bool(c.findings) != named:
        raise InputError("verdict, findings and extended model do not go together; diagnose again")
