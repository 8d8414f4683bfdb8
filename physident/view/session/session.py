"""A session: recordings, models, a diagnosis and a designed motion in one file that the rerun viewer opens."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.result.diagnosis import Diagnosis
from physident.diagnosis.result.saved import read_diagnosis
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.excitation.design import Design
from physident.excitation.motion.motion import Motion
from physident.files import write_with
from physident.recordings.recording import Recording
from physident.robots.robot import Robot
from physident.view.plan import plan_of
from physident.view.scene import colour_links, log_arm
from physident.view.session.bands import contact_intervals, log_bands
from physident.view.session.blueprint import Contained, Look, make_blueprint
from physident.view.session.content import Content, compose, identity
from physident.view.session.data import SessionData, gather, moving_rms
from physident.view.session.design import log_design
from physident.view.session.joints import log_joints
from physident.view.session.range import joint_ranges
from physident.view.session.text import findings, summary
from physident.view.viewer import open_window, serve

if TYPE_CHECKING:
    import rerun as rr

Array = NDArray[np.float64]
COLOUR_WINDOW = 0.5  # s: a link's colour is its residual's RMS over it, else it flickers
COLOUR_QUANTILE = 0.9  # of all joints and instants reach the full colour


def view(
    models: Estimate | Sequence[Estimate] | Mapping[str, Estimate] = (),
    recordings: Recording | Iterable[Recording] = (),
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
    """Show recordings, models, a diagnosis and a plan (or their files); ``to`` a file (.rrd), or in the viewer.

    Everything passes the filter of the first model, or one of ``cutoff`` [Hz]. ``progress`` is the condition number after
    each iteration of a design; ``meshes`` the folder that the robot's meshes lie in; ``robot`` is needed where there is no
    model. ``web`` serves the viewer to a browser on this machine at the address it prints, until it is interrupted.
    Raises InputError where nothing is given, the models are of different arms, or the file cannot be written.
    """
    said = read_diagnosis(diagnosis) if isinstance(diagnosis, str | Path) else None if diagnosis is None else diagnosis
    c = compose(_named(models), recordings, said, robot, cutoff)
    meshes = None if meshes is None else Path(meshes)
    c = replace(c, plan=None if plan is None else plan_of(plan, tuple(float(p) for p in progress)), meshes=meshes)
    if to is not None:
        write_session(c, to)
    if to is None or web:
        show(c, to, web)


def show(c: Content, path: str | Path | None, web: bool) -> None:
    """Open a session that was written to ``path``, or one that is kept only while it is looked at."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        kept = Path(folder, "session.rrd") if path is None else Path(path)
        if path is None:
            write_session(c, kept)
        if web:
            serve(kept)
        else:
            open_window(kept)


def write_session(c: Content, path: str | Path) -> None:
    """Write a session as a rerun recording (.rrd), whole or not at all."""
    check_session(path)
    if not c.recordings and c.plan is None:
        raise InputError("nothing to show: expected a recording or a designed motion")
    if c.plan is not None and c.plan.motion.n != c.robot.n:
        raise InputError(
            f"the plan moves {c.plan.motion.n} joints, robot {c.robot.name} has {c.robot.n}; expected one arm"
        )
    data = gather(c.recordings, c.models, c.robot, c.filter) if c.recordings else None
    write_with(path, lambda temporary: _record(c, data, temporary))


def check_session(path: str | Path) -> None:
    """Raises InputError for the path of a session that the viewer would not take for one."""
    if Path(path).suffix.lower() != ".rrd":
        raise InputError(f"session {str(path)!r} has no known ending, expected .rrd")


def _record(c: Content, data: SessionData | None, path: Path) -> None:
    import rerun as rr

    name = hashlib.sha256("".join([*(r.sha256 for r in c.recordings), *map(identity, c.models.values())]).encode())
    rec = rr.RecordingStream("physident", recording_id=name.hexdigest()[:32], send_properties=False)
    rec.save(path)
    rec.send_recording_name(f"{c.robot.name}: {', '.join(Path(r.source).name for r in c.recordings) or 'design'}")
    been, planned, scale = np.zeros((1, 3)), np.zeros((1, 3)), c.robot.name
    if data is not None:
        been = log_arm(rec, "robot", c.robot, data.clock, data.motion, c.meshes)
        scale = _colour(rec, c, data)
        log_joints(rec, data, c.robot)
        log_bands(rec, data, contact_intervals(data, c.diagnosis.extended if c.diagnosis else None))
        rec.log(
            "summary", rr.TextDocument(summary(data, c.robot, c.diagnosis), media_type="text/markdown"), static=True
        )
    if c.diagnosis is not None:
        rec.log("diagnosis", rr.TextDocument(findings(c.diagnosis), media_type="text/markdown"), static=True)
    if c.plan is not None:
        planned = log_design(rec, c.plan, c.robot, c.meshes)
    look = (Look.at(been, scale), Look.at(planned, f"{c.robot.name}, planned motion"))
    rec.send_blueprint(make_blueprint(_contained(c, data, *look)))
    rec.flush()
    rec.disconnect()


def _colour(rec: rr.RecordingStream, c: Content, data: SessionData) -> str:
    """Colour the links by the first model's residual; returns how to read the colours."""
    if not data.predictions:
        return c.robot.name
    first = data.predictions[0]
    known = np.isfinite(data.measured)
    size = np.sqrt(np.sum(data.measured**2, axis=0, where=known) / np.maximum(known.sum(axis=0), 1))
    share = moving_rms(data.residual(first), data.time, COLOUR_WINDOW) / np.where(size > 0, size, np.inf)
    told = share[np.isfinite(share)]
    full = float(np.quantile(told, COLOUR_QUANTILE)) if told.any() else 1.0
    colour_links(rec, "robot", c.robot, data.time, share / full, c.meshes)
    return f"link colour: residual, grey 0 to orange {100 * full:.0f} % of the torque"


def _contained(c: Content, data: SessionData | None, arm: Look, planned: Look) -> Contained:
    last = data.predictions[-1] if data is not None and data.predictions else None
    return Contained(
        joints=c.robot.joint_names,
        prismatic=tuple(joint.kind == "prismatic" for joint in c.robot.joints),
        first=data.predictions[0].name if last is not None and data is not None else None,
        effects_of=last.name if last is not None else None,
        models=len(data.predictions) if data is not None else 0,
        effects=len(last.effects) if last is not None else 0,
        found=tuple(dict.fromkeys(j for f in (c.diagnosis.findings if c.diagnosis else ()) for j in f.joints)),
        end=0.0 if data is None else data.starts[-1] + data.durations[-1],
        design_end=0.0 if c.plan is None else c.plan.motion.duration,
        recorded=data is not None,
        diagnosed=c.diagnosis is not None,
        planning=c.plan is not None,
        progress=c.plan is not None and bool(c.plan.progress),
        designed=c.plan is not None and bool(c.plan.design),
        arm=arm,
        planned=planned,
        ranges={} if data is None else joint_ranges(data),
    )


def _named(models: Estimate | Sequence[Estimate] | Mapping[str, Estimate]) -> dict[str, Estimate]:
    if isinstance(models, Mapping):
        return dict(models)
    listed = [models] if isinstance(models, Estimate) else list(models)
    return {"model" if len(listed) == 1 else f"model {i}": m for i, m in enumerate(listed, 1)}
