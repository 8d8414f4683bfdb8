"""Show recordings, models, a diagnosis and a planned motion in the rerun viewer, or write them as a session file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from physident.diagnosis.result.diagnosis import Diagnosis
from physident.diagnosis.result.saved import read_diagnosis
from physident.estimation.estimate import Estimate
from physident.excitation.design import Design
from physident.excitation.motion.motion import Motion
from physident.graphics.plan import plan_of
from physident.graphics.session.content import SessionContent, compose
from physident.graphics.session.write import write_session
from physident.graphics.viewer import open_window, serve
from physident.recordings.load import Recordings
from physident.robots.robot import Robot


def view(
    models: Estimate | Sequence[Estimate] | Mapping[str, Estimate] = (),
    recordings: Recordings = (),
    diagnosis: Diagnosis | str | Path | None = None,
    to: str | Path | None = None,
    *,
    plan: Motion | Design | str | Path | None = None,
    progress: Sequence[float] = (),
    robot: Robot | None = None,
    cutoff: float | None = None,
    meshes: str | Path | None = None,
    web: bool = False,
) -> None:
    """Show recordings, models, a diagnosis and a planned motion in the viewer, or write them ``to`` a session file (.rrd).

    ``diagnosis`` and ``plan`` may be files. Everything passes the low-pass of the first model, or one of ``cutoff`` [Hz].
    ``progress`` is the condition number after each iteration of a design. ``robot`` is needed where no model is given;
    ``meshes`` is the folder of its mesh packages. ``web`` serves the viewer to a browser on this machine, at the address
    that it prints, until it is interrupted.

    Raises InputError where nothing is given to show, for models of different arms, and for a file that cannot be written.
    """
    if isinstance(diagnosis, str | Path):
        contents = read_diagnosis(diagnosis)
    else:
        contents = None if diagnosis is None else diagnosis
    content = replace(
        compose(_named(models), recordings, contents, robot, cutoff),
        plan=None if plan is None else plan_of(plan, tuple(float(p) for p in progress)),
        meshes=None if meshes is None else Path(meshes),
    )
    if to is not None:
        write_session(content, to)
    if to is None or web:
        show(content, to, web)


def show(content: SessionContent, path: str | Path | None, web: bool) -> None:
    """Open the session that was written to ``path``; without a path, write it to a temporary file first."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "session.rrd") if path is None else Path(path)
        if path is None:
            write_session(content, file)
        if web:
            serve(file)
        else:
            open_window(file)


def _named(models: Estimate | Sequence[Estimate] | Mapping[str, Estimate]) -> dict[str, Estimate]:
    """The models by name; without names they are numbered."""
    if isinstance(models, Mapping):
        return dict(models)
    listed = [models] if isinstance(models, Estimate) else list(models)
    return {"model" if len(listed) == 1 else f"model {i}": m for i, m in enumerate(listed, 1)}
