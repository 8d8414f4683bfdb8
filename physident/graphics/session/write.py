"""Write a session: recordings, models, a diagnosis and a planned motion in one file that the rerun viewer opens."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError, NotSolvedError
from physident.graphics.scene import colour_links, log_arm
from physident.graphics.session.axis_ranges import joint_ranges
from physident.graphics.session.bands import contact_intervals, log_bands
from physident.graphics.session.blueprint import Camera, Outline, make_blueprint
from physident.graphics.session.content import SessionContent, model_hash
from physident.graphics.session.data import SessionData, gather, moving_rms
from physident.graphics.session.design import log_design
from physident.graphics.session.joints import log_joints
from physident.graphics.session.learned import learned_curves, log_learned
from physident.graphics.session.recorded import log_recordings
from physident.graphics.session.text import findings, summary
from physident.outputs import write_with

if TYPE_CHECKING:
    import rerun as rr

Array = NDArray[np.float64]
END = b"RRF2FOOT"  # a complete session ends with this word and a number of four bytes
COLOUR_WINDOW = 0.5  # s: a link's colour is the RMS of its residual over this window; without one it would flicker
COLOUR_QUANTILE = 0.9  # of the residuals of all joints and instants: this size gets the full colour


def write_session(content: SessionContent, path: str | Path) -> None:
    """Write a session as a rerun recording (.rrd), whole or not at all.

    Raises InputError for a path without that ending, for nothing to show, and for a plan of another number of joints.
    """
    check_session_path(path)
    if not content.recordings and content.plan is None:
        raise InputError("nothing to show: expected a recording or a planned motion")
    if content.plan is not None and content.plan.motion.n != content.robot.n:
        raise InputError(
            f"the plan moves {content.plan.motion.n} joints, robot {content.robot.name} has {content.robot.n}; expected both of one arm"
        )
    data = None
    if content.recordings:
        data = gather(content.recordings, content.models, content.robot, content.filter)
    write_with(path, lambda temporary: _write(content, data, temporary))


def check_session_path(path: str | Path) -> None:
    """Raises InputError for a path without the ending by which the viewer knows a session."""
    if Path(path).suffix.lower() != ".rrd":
        raise InputError(f"session {str(path)!r} has no known ending, expected .rrd")


def _write(content: SessionContent, data: SessionData | None, path: Path) -> None:
    import rerun as rr

    robot, diagnosis = content.robot, content.diagnosis
    hashes = [*(r.sha256 for r in content.recordings), *map(model_hash, content.models.values())]
    recording_id = hashlib.sha256("".join(hashes).encode()).hexdigest()[:32]
    rec = rr.RecordingStream("physident", recording_id=recording_id, send_properties=False)
    memory = rec.memory_recording()  # its own file sink does not report a full disk
    rec.send_recording_name(f"{robot.name}: {', '.join(Path(r.source).name for r in content.recordings) or 'design'}")
    recorded_points, planned_points, title = np.zeros((1, 3)), np.zeros((1, 3)), robot.name
    if data is not None:
        recorded_points = log_arm(rec, "robot", robot, data.clock, data.motion, content.meshes)
        title = _colour_links(rec, content, data)
        log_joints(rec, data, robot)
        log_recordings(rec, content.recordings)
        log_bands(rec, data, contact_intervals(data, diagnosis.extended if diagnosis else None))
        rec.log("summary", rr.TextDocument(summary(data, robot, diagnosis), media_type="text/markdown"), static=True)
    if diagnosis is not None:
        rec.log("diagnosis", rr.TextDocument(findings(diagnosis), media_type="text/markdown"), static=True)
        log_learned(rec, diagnosis)
    if content.plan is not None:
        planned_points = log_design(rec, content.plan, robot, content.meshes)
    cameras = Camera.around(recorded_points, title), Camera.around(planned_points, f"{robot.name}, planned motion")
    rec.send_blueprint(make_blueprint(_outline(content, data, *cameras)))
    rec.flush()
    session = memory.drain_as_bytes()
    rec.disconnect()
    if END not in session[-len(END) - 4 :]:
        raise NotSolvedError(
            f"the session is not complete ({len(session)} bytes without an end); view shorter recordings"
        )
    path.write_bytes(session)


def _colour_links(rec: rr.RecordingStream, content: SessionContent, data: SessionData) -> str:
    """Colour the links by the first model's residual; returns a title that explains the colours."""
    if not data.predictions:
        return content.robot.name
    residual, known = data.residual(data.predictions[0]), np.isfinite(data.measured)
    torque = np.sqrt(np.sum(data.measured**2, axis=0, where=known) / np.maximum(known.sum(axis=0), 1))
    share = moving_rms(residual, data.time, COLOUR_WINDOW) / np.where(torque > 0, torque, np.inf)
    finite = share[np.isfinite(share)]
    full = float(np.quantile(finite, COLOUR_QUANTILE)) if finite.any() else 1.0
    colour_links(rec, "robot", content.robot, data.time, share / full, content.meshes)
    return f"link colour: residual, grey 0 to orange {100 * full:.0f} % of the torque"


def _outline(content: SessionContent, data: SessionData | None, arm: Camera, planned: Camera) -> Outline:
    last = data.predictions[-1] if data is not None and data.predictions else None
    named = content.diagnosis.findings if content.diagnosis else ()
    return Outline(
        joints=content.robot.joint_names,
        prismatic=tuple(joint.kind == "prismatic" for joint in content.robot.joints),
        first_model=data.predictions[0].name if last is not None and data is not None else None,
        last_model=last.name if last is not None else None,
        models=len(data.predictions) if data is not None else 0,
        effects=len(last.effects) if last is not None else 0,
        named_joints=tuple(dict.fromkeys(joint for finding in named for joint in finding.joints)),
        end=0.0 if data is None else data.starts[-1] + data.durations[-1],
        design_end=0.0 if content.plan is None else content.plan.motion.duration,
        has_recordings=data is not None,
        has_diagnosis=content.diagnosis is not None,
        has_plan=content.plan is not None,
        has_design=content.plan is not None and bool(content.plan.design),
        has_progress=content.plan is not None and bool(content.plan.progress),
        arm=arm,
        planned=planned,
        ranges={} if data is None else joint_ranges(data),
        learned=tuple(f"joint {one.joint} over {one.quantity}" for one in learned_curves(content.diagnosis)),
    )
