"""Write a session: recordings, models, a diagnosis and a planned motion in one file that the rerun viewer opens."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.result.record import DiagnosisRecord
from physident.errors import InputError, NotSolvedError
from physident.graphics.scene import colour_links, log_arm
from physident.graphics.session.axis_ranges import joint_extents
from physident.graphics.session.bands import contact_intervals, log_bands
from physident.graphics.session.blueprint import Camera, Outline, make_blueprint
from physident.graphics.session.content import SessionContent, model_hash
from physident.graphics.session.data import SessionData, gather, moving_rms
from physident.graphics.session.design import log_design
from physident.graphics.session.joints import log_joints
from physident.graphics.session.learned import learned_curves, log_learned
from physident.graphics.session.recorded import log_recordings
from physident.graphics.session.text import findings, summary
from physident.graphics.style import effect_colour
from physident.outputs import write_with

if TYPE_CHECKING:
    pass

Array = NDArray[np.float64]
END = b"RRF2FOOT"  # a complete session ends with this word and a number of four bytes
COLOUR_WINDOW = 0.5  # s: a link's colour is the RMS of its residual over this window; without one it would flicker
COVER = -1.0  # s: before the recordings, where a session opens, everything stands as at the most telling instant
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
    beside: tuple[int, ...] = ()
    recorded_points, planned_points, title = np.zeros((1, 3)), np.zeros((1, 3)), robot.name
    if data is not None:
        shares, full = _residual_shares(data)
        told = _explained(data) if diagnosis and diagnosis.extended else shares
        shown = _most_telling(told, named_joints(diagnosis))
        if diagnosis is not None and shown is not None:
            beside = named_joints(diagnosis) or tuple(int(j) + 1 for j in np.argsort(-np.nan_to_num(told[shown])))
        cover = None if shown is None else (COVER, data.q[shown])
        recorded_points = log_arm(
            rec, "robot", robot, data.clock, data.motion, content.meshes, cover=cover, marked=_marks(diagnosis)
        )
        if shown is not None:
            clock, row = np.append(COVER, data.time), np.append(shown, np.arange(len(data.time)))
            colour_links(rec, "robot", robot, clock, shares[row], content.meshes)
            title = f"orange: residual, full at {100 * full:.0f} % of the torque; opens as at {data.time[shown]:.1f} s"
        log_joints(rec, data, robot, None if shown is None else (COVER, shown))
        log_recordings(rec, content.recordings)
        log_bands(rec, data, contact_intervals(data, diagnosis.extended if diagnosis else None))
        rec.log("summary", rr.TextDocument(summary(data, robot, diagnosis), media_type="text/markdown"), static=True)
    if diagnosis is not None:
        rec.log("diagnosis", rr.TextDocument(findings(diagnosis), media_type="text/markdown"), static=True)
        log_learned(rec, diagnosis)
    if content.plan is not None:
        planned_points = log_design(rec, content.plan, robot, content.meshes)
    cameras = Camera.around(recorded_points, title), Camera.around(planned_points, f"{robot.name}, planned motion")
    rec.send_blueprint(make_blueprint(_outline(content, data, beside, *cameras)))
    rec.flush()
    session = memory.drain_as_bytes()
    rec.disconnect()
    if END not in session[-len(END) - 4 :]:
        raise NotSolvedError(
            f"the session is not complete ({len(session)} bytes without an end); view shorter recordings"
        )
    path.write_bytes(session)


def _residual_shares(data: SessionData) -> tuple[Array, float]:
    """The first model's residual (M, n), 1 where a link gets its full colour, and that residual as a share of the torque."""
    if not data.predictions:
        return np.zeros((0, data.n)), 1.0
    share = moving_rms(data.residual(data.predictions[0]), data.time, COLOUR_WINDOW) / _torque_sizes(data)
    finite = share[np.isfinite(share)]
    full = float(np.quantile(finite, COLOUR_QUANTILE)) if finite.any() else 1.0
    return share / (full or 1.0), full


def _torque_sizes(data: SessionData) -> Array:
    """The RMS (n,) of each joint's measured torque, infinite where there is none."""
    known = np.isfinite(data.measured)
    torque = np.sqrt(np.sum(data.measured**2, axis=0, where=known) / np.maximum(known.sum(axis=0), 1))
    return np.where(torque > 0, torque, np.inf)


def named_joints(diagnosis: DiagnosisRecord | None) -> tuple[int, ...]:
    """The joints (from 1) that a diagnosis names, in the order of its findings."""
    found = () if diagnosis is None else diagnosis.findings
    return tuple(dict.fromkeys(joint for finding in found for joint in finding.joints))


def _explained(data: SessionData) -> Array:
    """How much of a torque (M, n) the last model explains that the first does not."""
    gained = data.predictions[-1].torque - data.predictions[0].torque
    return moving_rms(gained, data.time, COLOUR_WINDOW) / _torque_sizes(data)


def _most_telling(shares: Array, named: Sequence[int]) -> int | None:
    """The row with the largest share (M, n), on the joints that are named if there are any; None where there is none."""
    looked = shares[:, [joint - 1 for joint in named]] if named else shares
    return int(np.nanargmax(np.nan_to_num(looked).max(axis=1))) if np.isfinite(looked).any() else None


def _marks(diagnosis: DiagnosisRecord | None) -> dict[int, str]:
    """The colour of the first cause of each joint (from 1)."""
    causes = () if diagnosis is None else diagnosis.causes
    return {joint: effect_colour(cause.effect) for cause in reversed(causes) for joint in cause.joints}


def _outline(
    content: SessionContent, data: SessionData | None, beside: tuple[int, ...], arm: Camera, planned: Camera
) -> Outline:
    last = data.predictions[-1] if data is not None and data.predictions else None
    return Outline(
        joints=content.robot.joint_names,
        prismatic=tuple(joint.kind == "prismatic" for joint in content.robot.joints),
        first_model=data.predictions[0].name if last is not None and data is not None else None,
        last_model=last.name if last is not None else None,
        models=len(data.predictions) if data is not None else 0,
        effects=len(last.effects) if last is not None else 0,
        joints_beside=beside,
        end=0.0 if data is None else data.starts[-1] + data.durations[-1],
        design_end=0.0 if content.plan is None else content.plan.motion.duration,
        has_recordings=data is not None,
        has_diagnosis=content.diagnosis is not None,
        has_plan=content.plan is not None,
        has_design=content.plan is not None and bool(content.plan.design),
        has_progress=content.plan is not None and bool(content.plan.progress),
        arm=arm,
        planned=planned,
        moving=(0.0, 0.0) if data is None else (float(data.time[0]), float(data.time[-1])),
        extents={} if data is None else joint_extents(data),
        learned=tuple(f"joint {one.joint} over {one.quantity}" for one in learned_curves(content.diagnosis)),
    )
