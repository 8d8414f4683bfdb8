"""The origin of the page: files, hashes, versions and commands."""

from __future__ import annotations

import hashlib
import platform
import shlex
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from markupsafe import Markup

from physident.diagnosis.result.findings import UsedRecording
from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import AS_IT_WAS, EXTENDED
from physident.dynamics.model import Model
from physident.effects.catalogue import effects_from
from physident.files import VERSION
from physident.report.markup import table, tag
from physident.report.numbers import SPACE
from physident.report.reread import Reread

PACKAGES = {"numpy": "numpy", "scipy": "scipy", "Pinocchio": "pin"}  # the usual name, and that of the package


def provenance(c: DiagnosisRecord, recordings: Sequence[Reread], command: str) -> Markup:
    """A table of the recordings, and one of everything else."""
    rows = [[one.used.path, _role(one.used), tag("code", one.used.sha256), one.status] for one in recordings]
    return tag(
        "section",
        tag("h2", "Origin of this page"),
        table(["recording", "used as", "SHA-256 of its data", "now"], rows, class_="files"),
        table(["", ""], [[name, value] for name, value in _facts(c, command)], class_="files"),
    )


def _role(used: UsedRecording) -> str:
    return used.role if used.repeats is None else f"{used.role}; repeats the motion of {Path(used.repeats).name}"


def _facts(c: DiagnosisRecord, command: str) -> list[tuple[str, str]]:
    robot = c.model.robot
    rows: list[tuple[str, str]] = []
    if c.path is not None:
        rows.append(("diagnosis", tag("span", str(c.path), " ", tag("code", c.sha256 or ""))))
    rows += [
        ("robot", f"{robot.name}, {robot.n} joint{'s' if robot.n > 1 else ''}"),
        (AS_IT_WAS, _model(c.model)),
        *([(EXTENDED, _model(c.extended))] if c.extended is not None else []),
        ("low-pass", f"{c.filter.cutoff:g}{SPACE}Hz, the same for the torque and for every column of the model"),
    ]
    if c.layout is not None:
        rows.append(("columns", tag("code", c.layout)))
    if c.drive_gains is not None:
        rows.append(("drive gains", f"{' '.join(f'{g:g}' for g in c.drive_gains)}{SPACE}N{SPACE}m/A"))
    rows.append(("diagnose again", tag("code", _again(c))))
    if command:
        rows.append(("this page", tag("code", command)))
    versions = [f"physident {VERSION}", *(f"{name} {version(p)}" for name, p in PACKAGES.items())]
    rows.append(("written by", f"{', '.join(versions)}, Python {platform.python_version()}"))
    return rows


def _model(model: Model) -> Markup:
    """The effects of a model, and a hash of its parameters, by which two pages can be compared."""
    names = list(dict.fromkeys(effect.name for effect in model.effects))
    digest = hashlib.sha256(model.theta.astype("<f8").tobytes()).hexdigest()
    text = f"{', '.join(names)}; {len(model.theta)} parameters, SHA-256 of their values "
    return tag("span", text, tag("code", digest))


def _again(c: DiagnosisRecord) -> str:
    """The command that repeats the diagnosis; where the model was never saved, a word stands for its file."""
    option, default = ("--robot", "ROBOT") if c.question == "nominal" else ("--model", "MODEL")
    words = ["physident", "diagnose", option, shlex.quote(c.model_file or default)]
    words += [shlex.quote(used.path) for used in c.recordings if used.role == "diagnosed"]
    for used in c.recordings:
        if used.role != "diagnosed":
            words += [f"--{used.role}", shlex.quote(used.path)]
    told = [f.effect for f in (*c.findings, *c.missing_since_before)]
    words += map(shlex.quote, effects_from([*told, *(effect.name for effect in c.model.effects)]))
    words += ["--recording-offsets"] if c.recording_offsets else []
    words += ["--seed", str(c.seed)] if c.seed else []
    return " ".join([*words, "--json", shlex.quote(c.path.name if c.path else "diagnosis.json")])
