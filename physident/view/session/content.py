"""What a session is made of."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from physident.diagnosis.result.saved import Contents
from physident.dynamics.model import Model
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter
from physident.robots.robot import Robot
from physident.view.plan import Plan


@dataclass(frozen=True, eq=False)
class Content:
    """What a session is made of, and the one filter that everything passes."""

    robot: Robot
    recordings: tuple[Recording, ...] = ()
    models: Mapping[str, Model] = field(default_factory=dict)
    diagnosis: Contents | None = None
    plan: Plan | None = None
    filter: Filter = field(default_factory=Filter)
    meshes: Path | None = None


def compose(
    models: Mapping[str, Estimate],
    recordings: Recording | Iterable[Recording],
    diagnosis: Contents | None,
    robot: Robot | None,
    cutoff: float | None,
) -> Content:
    """What is shown: the models given, and those of the diagnosis where they are others.

    Robot, filter and drive gains are those of the first model, else of the diagnosis, where nothing else is asked for.
    Raises InputError for a diagnosis of another arm, and where no robot is known.
    """
    shown = {name: estimate.model for name, estimate in models.items()}
    if diagnosis is not None:
        for name, model in shown.items():
            if model.robot.name != diagnosis.model.robot.name:
                raise InputError(
                    f"the diagnosis is of robot {diagnosis.model.robot.name}, model {name} is of {model.robot.name}; expected"
                    " a diagnosis and models of one arm"
                )
        known = {identity(m) for m in shown.values()}
        if identity(diagnosis.model) not in known:
            shown = {_free("diagnosed", shown): diagnosis.model, **shown}
        if diagnosis.extended is not None and identity(diagnosis.extended) not in known:
            shown[_free("extended", shown)] = diagnosis.extended
    first = next(iter(models.values()), None)
    chosen = robot if robot is not None else next((m.robot for m in shown.values()), None)
    if chosen is None:
        raise InputError("no robot is known: expected a model, a diagnosis, or a robot (--robot)")
    source = first if first is not None else diagnosis
    filter, gains = (source.filter, source.drive_gains) if source is not None else (Filter(), None)
    filter = Filter(cutoff if cutoff is not None else filter.cutoff, filter.rate)
    listed = (recordings,) if isinstance(recordings, Recording) else tuple(recordings)
    return Content(chosen, tuple(r.with_default_drive_gains(gains) for r in listed), shown, diagnosis, filter=filter)


def identity(model: Model) -> str:
    """What two models that are the same have in common."""
    return hashlib.sha256(repr(model.as_dict()).encode()).hexdigest()


def _free(name: str, taken: Mapping[str, Model]) -> str:
    return name if name not in taken else _free(f"{name} (diagnosis)", taken)
