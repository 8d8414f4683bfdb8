"""The content of a session: recordings, models, a diagnosis and a planned motion of one arm."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import AS_IT_WAS, EXTENDED
from physident.dynamics.model import Model
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.graphics.plan import Plan
from physident.recordings.load import Recordings, as_recordings
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter
from physident.robots.robot import Robot


@dataclass(frozen=True, eq=False)
class SessionContent:
    """The content of a session, and the filter that all torques pass. ``models`` are listed by the names that are shown."""

    robot: Robot
    recordings: tuple[Recording, ...] = ()
    models: Mapping[str, Model] = field(default_factory=dict)
    diagnosis: DiagnosisRecord | None = None
    plan: Plan | None = None
    filter: Filter = field(default_factory=Filter)
    meshes: Path | None = None


def compose(
    models: Mapping[str, Estimate],
    recordings: Recordings,
    diagnosis: DiagnosisRecord | None,
    robot: Robot | None,
    cutoff: float | None,
) -> SessionContent:
    """The content of a session: the models given, and those of the diagnosis that are not among them.

    Robot, filter and drive gains are those of the first model, or of the diagnosis where no model is given; ``robot`` and
    ``cutoff`` [Hz] replace them. Raises InputError for a diagnosis of another arm, and where no robot is known.
    """
    shown = {name: estimate.model for name, estimate in models.items()}
    if diagnosis is not None:
        for name, model in shown.items():
            if model.robot.name != diagnosis.model.robot.name:
                raise InputError(
                    f"the diagnosis is of robot {diagnosis.model.robot.name}, model {name} is of {model.robot.name}; expected"
                    " both of one arm"
                )
        shown = _with_roles(shown, diagnosis)
    first = next(iter(models.values()), None)
    chosen = robot if robot is not None else next((m.robot for m in shown.values()), None)
    if chosen is None:
        raise InputError("no robot is given: expected a model, a diagnosis, or a robot (--robot)")
    source = first if first is not None else diagnosis
    filter, gains = (source.filter, source.drive_gains) if source is not None else (Filter(), None)
    filter = Filter(cutoff if cutoff is not None else filter.cutoff, filter.rate)
    layout = None if source is None else source.layout
    listed = as_recordings(recordings, chosen, layout)
    return SessionContent(
        chosen, tuple(r.with_default_drive_gains(gains) for r in listed), shown, diagnosis, filter=filter
    )


def model_hash(model: Model) -> str:
    """A hash of a model, equal for equal models."""
    return hashlib.sha256(repr(model.as_dict()).encode()).hexdigest()


def _with_roles(models: Mapping[str, Model], diagnosis: DiagnosisRecord) -> dict[str, Model]:
    """The models and both of a diagnosis, each once; those of the diagnosis have the names of their roles."""
    both = {AS_IT_WAS: diagnosis.model} | ({} if diagnosis.extended is None else {EXTENDED: diagnosis.extended})
    roles = {model_hash(model): role for role, model in both.items()}
    named = {roles.get(model_hash(m), f"{name} (given)" if name in both else name): m for name, m in models.items()}
    return ({} if AS_IT_WAS in named else {AS_IT_WAS: diagnosis.model}) | named | both
