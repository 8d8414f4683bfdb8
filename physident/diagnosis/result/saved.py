"""A diagnosis file, read back and checked."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any, Literal

import numpy as np

from physident.diagnosis.problem.question import Question
from physident.diagnosis.remainder.unexplained import Unexplained
from physident.diagnosis.result.findings import Finding, JointErrors, Placebo, Unseen, UsedRecording, Verdict
from physident.diagnosis.result.record import SCHEMA, DiagnosisRecord
from physident.diagnosis.result.simulated import Simulated
from physident.dynamics.model_entries import read_model
from physident.effects.catalogue import CATALOGUE
from physident.errors import InputError
from physident.files import naming, read_json
from physident.json_records import RecordReader
from physident.recordings.signals import Filter

EARLIER = {  # what findings of earlier versions did not have
    "grade": "cause",
    "takes_percent": None,
    "leaves_percent": None,
    "stability": None,
    "doubts": [],
    "confounder": "",
    "in_words": "",
    "curves": [],
    "no_cause": "",
    "handed_on": True,
    "mostly_new": False,
    "threshold": None,
}
READER = RecordReader("diagnose again")
MAX_BYTES = 200_000_000  # of a diagnosis file
EXPECTED = "a diagnosis of motions that physident diagnose --json wrote"


def read_diagnosis(path: str | Path) -> DiagnosisRecord:
    """The record in a diagnosis file; raises InputError where it is missing, no JSON, of another schema, or incomplete."""
    data = read_json(path, MAX_BYTES, EXPECTED, SCHEMA)
    with naming(path, "diagnosis", "diagnose again"):
        return _parsed(data, Path(path), hashlib.sha256(Path(path).read_bytes()).hexdigest())


def _parsed(data: dict[str, Any], path: Path, sha256: str) -> DiagnosisRecord:
    score = READER.read(dict, data["score"], "score")
    floor = READER.read(tuple[float, ...] | None, score["noise_floor"], "score.noise_floor")
    record = DiagnosisRecord(
        path=path,
        sha256=sha256,
        question=READER.read(Question, data["question"], "question"),
        verdict=READER.read(Verdict, data["verdict"], "verdict"),
        findings=_findings(data["findings"], "findings"),
        before=_errors(score["before"], "score.before"),
        after=_errors(score["after"], "score.after"),
        scored_on=READER.read(Literal["holdout", "left-out rows"], score["on"], "score.on"),
        noise_floor=None if floor is None else np.array(floor),
        placebos=READER.read(tuple[Placebo, ...], data["placebos"], "placebos"),
        unseen=READER.read(tuple[Unseen, ...], data["unseen"], "unseen"),
        unexplained=READER.read(tuple[Unexplained, ...], _unexplained(data["unexplained"]), "unexplained"),
        recordings=READER.read(tuple[UsedRecording, ...], _used(data["recordings"]), "recordings"),
        filter=READER.read(Filter, data["filter"], "filter"),
        layout=READER.read(str | None, data["columns"], "columns"),
        drive_gains=READER.read(tuple[float, ...] | None, data["drive_gains"], "drive_gains"),
        unidentified=READER.read(tuple[str, ...], data["held"], "held"),
        incomplete=READER.read(tuple[int, ...], data["incomplete"], "incomplete"),
        seed=READER.read(int, data["seed"], "seed"),
        recording_offsets=READER.read(bool, data["recording_offsets"], "recording_offsets"),
        simulated=READER.read(Simulated | None, data.get("simulated"), "simulated"),
        missing_since_before=_findings(data.get("missing_since_before", []), "missing_since_before"),
        wrong_baseline=READER.read(tuple[int, ...], data.get("wrong_baseline", []), "wrong_baseline"),
        wrong_unseen=READER.read(tuple[int, ...], data.get("wrong_unseen", []), "wrong_unseen"),
        controlled=READER.read(bool | None, data.get("controlled"), "controlled"),
        warnings=READER.read(tuple[str, ...], data.get("warnings", []), "warnings"),
        model_file=READER.read(str | None, data.get("model_file"), "model_file"),  # absent in files of earlier versions
        extended_file=READER.read(str | None, data.get("extended_file"), "extended_file"),
        model=read_model(data["model"], READER, "model"),
        extended=None if (given := data["extended_model"]) is None else read_model(given, READER, "extended_model"),
    )
    _check(record)
    return record


def _errors(entry: Any, where: str) -> JointErrors:
    """Errors of one model; those of a file from before rests were told apart are of all rows too."""
    data = READER.read(dict, entry, where)
    name = "relative_percent_all" if "relative_percent_all" in data else "relative_percent"
    values = (READER.read(tuple[float, ...], data[key], f"{where}.{key}") for key in ("rms", name))
    return JointErrors(*(np.array(v) for v in values))


def _findings(data: Any, where: str) -> tuple[Finding, ...]:
    """Findings; those of a file from before there were grades are causes."""
    if isinstance(data, list) and all(isinstance(one, dict) for one in data):
        data = [
            {**EARLIER, **one, "rivals": _rivals(one.get("rivals")), "parameters": _values(one.get("parameters"))}
            for one in data
        ]
    return READER.read(tuple[Finding, ...], data, where)


def _values(data: Any) -> Any:
    """Values; in a file from before a change had an interval of its own, that of the value is as wide."""
    if not (isinstance(data, list) and all(isinstance(one, dict) for one in data)):
        return data
    return [one if "change_interval95" in one else {**one, "change_interval95": _moved(one)} for one in data]


def _moved(value: dict[str, Any]) -> Any:
    try:
        return [end - value["value"] + value["change"] for end in value["interval95"]]
    except (KeyError, TypeError):
        return None  # the reader says what is wrong with it


def _unexplained(data: Any) -> Any:
    """What stays unexplained; a file from before there was a bound on what a function of state can take has none, and one from before several
    times were told has one or none."""
    if not (isinstance(data, list) and all(isinstance(one, dict) for one in data)):
        return data
    told = ([one["burst"]] if one.get("burst") else [] for one in data)
    return [
        {
            "predictable": None,
            "friction_between": None,
            "bursts": bursts,
            "times_own": None,
            "usual_times": None,
            "times_noise": None,
            "slowest": 0.0,
            "unproven": None,
            **one,
        }
        for one, bursts in zip(data, told, strict=True)
    ]


def _used(data: Any) -> Any:
    """The recordings; those of a file from before motions were compared repeat none."""
    plain = isinstance(data, list) and all(isinstance(one, dict) for one in data)
    return [{"repeats": None, **one} for one in data] if plain else data


def _rivals(data: Any) -> Any:
    """Rivals; those of a file from before any was known to be inseparable are separable."""
    plain = isinstance(data, list) and all(isinstance(one, dict) for one in data)
    return [{"inseparable": False, **one} for one in data] if plain else data


def _check(c: DiagnosisRecord) -> None:
    """Raises InputError where the parts do not fit one another, as in a file edited by hand."""
    n = c.model.robot.n
    for name, level in (("score.before", c.before), ("score.after", c.after)):
        if len(level.rms) != n or len(level.relative) != n:
            raise InputError(f"{name} has {len(level.rms)} joints, expected the robot's {n}")
        if min((*level.rms, *level.relative)) < 0:
            raise InputError(f"{name} has a negative error; expected sizes")
    if c.noise_floor is not None and len(c.noise_floor) != n:
        raise InputError(f"score.noise_floor has {len(c.noise_floor)} joints, expected the robot's {n}")
    if c.simulated is not None and {len(c.simulated.before), len(c.simulated.after or c.simulated.before)} != {n}:
        raise InputError(f"simulated has {len(c.simulated.before)} joints, expected the robot's {n}")
    if c.extended is not None and c.extended.robot.n != n:
        raise InputError(f"the extended model has {c.extended.robot.n} joints, the model {n}; expected one robot")
    named_effects = (*c.findings, *c.missing_since_before)
    for effect in [*(f.effect for f in named_effects), *(r.effect for f in named_effects for r in f.rivals)]:
        if effect not in CATALOGUE:
            raise InputError(
                f"effect {effect!r} is not in the catalogue; expected a diagnosis of this version, or --effects-from with the file"
                " that defines the effect"
            )
    joints = [j for one in (*named_effects, *c.unseen) for j in one.joints]
    if wrong := [
        j for j in (*joints, *c.incomplete, *c.wrong_baseline, *(r.joint for r in c.unexplained)) if not 1 <= j <= n
    ]:
        raise InputError(f"joint {wrong[0]} is named, expected 1 to {n}")
    named = c.verdict in ("explained", "partly_explained")
    carried = [f for f in named_effects if f.grade != "hint" and f.handed_on]
    if bool(carried) != (c.extended is not None) or bool(c.causes) != named:
        raise InputError("verdict, findings and extended model do not go together; diagnose again")
