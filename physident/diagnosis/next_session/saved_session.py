"""A planned session, read back from its folder: its legs with their recordings, and what it was expected to settle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.saved import read_diagnosis
from physident.dynamics.model import Model
from physident.dynamics.model_entries import read_model
from physident.effects.catalogue import CATALOGUE
from physident.errors import InputError
from physident.excitation.motion.motion import Motion
from physident.excitation.motion.trajectory import load_trajectory
from physident.excitation.session.plan import Budget
from physident.excitation.session.questions import Kind
from physident.excitation.session.session import FILE, SCHEMA
from physident.files import naming, read_json
from physident.json_records import Range, RecordReader

READER = RecordReader("plan again")
EXPECTED = "the folder of a session that physident plan wrote"
MAX_BYTES = 50_000_000  # of session.json


@dataclass(frozen=True, kw_only=True)
class SavedLeg:
    """A leg as session.json has it."""

    name: str
    role: Literal["fit", "holdout", "warm-up"]
    loaded: bool
    duration: float
    purpose: str


@dataclass(frozen=True, kw_only=True)
class SavedExpectation:
    """A question and what was expected of it, as session.json has it."""

    kind: Kind
    question: str
    effect: str
    joints: tuple[int, ...]
    rival: str
    rival_joints: tuple[int, ...]
    parameter: Annotated[int, Range(0)]
    size: float
    power: float
    smallest: float | None
    detail: str


@dataclass(frozen=True, kw_only=True, eq=False)
class SavedSession:
    """A session in its ``folder``: legs, ``motions`` in their order, what was expected, the ``model`` it was planned with, the
    ``diagnosis`` it was planned from (None: a first session), and its ``budget``."""

    folder: Path
    legs: tuple[SavedLeg, ...]
    motions: tuple[Motion, ...]
    expectations: tuple[SavedExpectation, ...]
    model: Model
    diagnosis: DiagnosisRecord | None
    budget: Budget


def read_session(folder: str | Path) -> SavedSession:
    """The session in a folder; raises InputError where files are missing, of another schema, or do not fit one another."""
    path = Path(folder)
    file = path / FILE if path.is_dir() else path
    data = read_json(file, MAX_BYTES, EXPECTED, SCHEMA)
    if "settings" not in data or "expectations" not in data:
        raise InputError(f"{file}: has no settings or expectations, expected {EXPECTED}")
    with naming(file, "session", "plan again"):
        legs = READER.read(tuple[SavedLeg, ...], data["legs"], "legs")
        expectations = READER.read(tuple[SavedExpectation, ...], data["expectations"], "expectations")
        named = [one.effect for one in expectations if one.effect] + [one.rival for one in expectations if one.rival]
        if unknown := [name for name in named if name not in CATALOGUE]:
            raise InputError(f"effect {unknown[0]!r} is not in the catalogue; expected a session of this version")
        if any("/" in leg.name or "\\" in leg.name for leg in legs):
            raise InputError("a leg has a slash in its name; expected the name of a file in the session's folder")
        model = read_model(data["model"], READER, "model")
        budget = _budget(data["settings"])
        has_diagnosis = READER.read(str | None, data.get("diagnosis"), "diagnosis") is not None
    diagnosis = read_diagnosis(file.parent / "diagnosis.json") if has_diagnosis else None
    motions = tuple(load_trajectory(file.parent / f"{leg.name}.json") for leg in legs)
    return SavedSession(
        folder=file.parent, legs=legs, motions=motions, expectations=expectations, model=model, diagnosis=diagnosis,
        budget=budget,
    )  # fmt: skip


def match_recordings(session: SavedSession, paths: Sequence[str]) -> dict[str, str]:
    """The recording of each leg by its name: by the files' names where they begin with a leg's, else in the order of the legs.

    Raises InputError where some names fit and others do not, and for another number of recordings than of legs.
    """
    names = [leg.name for leg in session.legs]
    fits = [[name for name in names if Path(path).name.startswith(name)] for path in paths]
    if all(len(one) == 1 for one in fits) and len({one[0] for one in fits}) == len(paths):
        return {one[0]: path for one, path in zip(fits, paths, strict=True)}
    if any(fits):
        stray = next(path for path, one in zip(paths, fits, strict=True) if len(one) != 1)
        raise InputError(
            f"{stray}: which piece is this? expected file names that begin with one of {', '.join(names)}, each once"
        )
    needed = [leg.name for leg in session.legs if leg.role != "warm-up"]
    chosen = names if len(paths) == len(names) else needed
    if len(paths) != len(chosen):
        raise InputError(
            f"{len(paths)} recordings, expected {len(needed)} in the order of the session (without the warm-up), or file names that"
            f" begin with the pieces' names: {', '.join(names)}"
        )
    return dict(zip(chosen, paths, strict=True))


def _budget(data: Any) -> Budget:
    """The budget as the settings have it."""
    settings = READER.read(dict, data, "settings")
    kinds: dict[str, Any] = {
        "minutes": float, "load": float | None, "limits": Literal["all", "joint"], "table": float | None, "clearance": float,
        "meshes": str | None, "seed": int, "pool": int,
    }  # fmt: skip
    return Budget(**{key: READER.read(kind, settings.get(key), f"settings.{key}") for key, kind in kinds.items()})
