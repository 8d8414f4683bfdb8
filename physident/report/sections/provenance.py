"""Where the page comes from: files, hashes, versions, commands."""

from __future__ import annotations

import hashlib
import platform
import shlex
from collections.abc import Sequence
from importlib.metadata import version

from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import came
from physident.dynamics.model import Model
from physident.files import VERSION
from physident.report.markup import Markup, table, tag
from physident.report.numbers import SPACE
from physident.report.reread import Reread

PACKAGES = {"numpy": "numpy", "scipy": "scipy", "Pinocchio": "pin"}  # as people and as installers call them


def provenance(c: DiagnosisRecord, read: Sequence[Reread], command: str) -> Markup:
    """Tables of the recordings and of everything else; the last section."""
    rows = [[one.used.path, one.used.role, tag("code", one.used.sha256), one.said] for one in read]
    return tag(
        "section",
        tag("h2", "Where this comes from"),
        table(["recording", "used as", "SHA-256 of its data", "now"], rows, class_="files"),
        table(["", ""], [[name, value] for name, value in _facts(c, command)], class_="files"),
    )


def _facts(c: DiagnosisRecord, command: str) -> list[tuple[str, str]]:
    robot = c.model.robot
    rows: list[tuple[str, str]] = []
    if c.path is not None:
        rows.append(("diagnosis", tag("span", str(c.path), " ", tag("code", c.sha256 or ""))))
    rows += [
        ("robot", f"{robot.name}, {robot.n} joint{'s' if robot.n > 1 else ''}"),
        (came(c.question), _model(c.model)),
        *([("extended model", _model(c.extended))] if c.extended is not None else []),
        ("low-pass", f"{c.filter.cutoff:g}{SPACE}Hz, the same on torque and on every column of the model"),
    ]
    if c.columns is not None:
        rows.append(("columns", tag("code", c.columns)))
    if c.drive_gains is not None:
        rows.append(("drive gains", f"{' '.join(f'{g:g}' for g in c.drive_gains)}{SPACE}N{SPACE}m/A"))
    rows.append(("diagnose again", tag("code", _again(c))))
    if command:
        rows.append(("this page", tag("code", command)))
    versions = [f"physident {VERSION}", *(f"{name} {version(p)}" for name, p in PACKAGES.items())]
    rows.append(("written by", f"{', '.join(versions)}, Python {platform.python_version()}"))
    return rows


def _model(model: Model) -> Markup:
    """Its effects, and a hash of its parameters that tells whether two pages speak of the same model."""
    names = list(dict.fromkeys(effect.name for effect in model.effects))
    digest = hashlib.sha256(model.theta.astype("<f8").tobytes()).hexdigest()
    text = f"{', '.join(names)}; {len(model.theta)} parameters, SHA-256 of their values "
    return tag("span", text, tag("code", digest))


def _again(c: DiagnosisRecord) -> str:
    """The command that asks the same of the same recordings; the model's file is not known to a diagnosis."""
    words = ["physident", "diagnose", *(["--robot", "ROBOT"] if c.question == "nominal" else ["--model", "MODEL"])]
    words += [shlex.quote(used.path) for used in c.recordings if used.role != "holdout"]
    for used in c.recordings:
        if used.role == "holdout":
            words += ["--holdout", shlex.quote(used.path)]
    words += ["--recording-offsets"] if c.recording_offsets else []
    words += ["--seed", str(c.seed)] if c.seed else []
    return " ".join([*words, "--json", shlex.quote(c.path.name if c.path else "diagnosis.json")])
