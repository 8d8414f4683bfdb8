"""A session of a replay for the rerun viewer: the measured arm, and where each model's simulation expects it."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.graphics import style
from physident.graphics.scene import link_poses, log_arm, tint, tool_path
from physident.graphics.session.blueprint import Camera
from physident.graphics.session.log import curve, rgb
from physident.graphics.session.write import check_session_path
from physident.outputs import write_with
from physident.replay.replay import Replayed
from physident.robots.robot import Robot

Array = NDArray[np.float64]
ARMS = (("before", style.RESIDUAL), ("after", style.PREDICTED))
ALPHA = 90  # of 255: a simulated arm is transparent
PAUSE = 1.0  # s between two recordings


def write_replay(replayed: Replayed, robot: Robot, path: str | Path, meshes: str | Path | None = None) -> None:
    """Write a replay as a rerun recording (.rrd), whole or not at all: the measured arm solid, simulated ones transparent.

    At every instant, a simulated arm stands where its simulation has arrived one horizon after an earlier measured state.
    Raises InputError for a path without that ending.
    """
    check_session_path(path)
    write_with(path, lambda temporary: _write(replayed, robot, temporary, meshes))


def _write(replayed: Replayed, robot: Robot, path: Path, meshes: str | Path | None) -> None:
    import rerun as rr
    import rerun.blueprint as rrb

    windows, horizon = replayed.windows, float(replayed.windows.clock[-1])
    offsets = np.cumsum([0.0, *(s.time[-1] - s.origin + PAUSE for s in replayed.signals)])[:-1]
    arrival = windows.start + offsets[windows.recording] + horizon
    order = np.argsort(arrival)
    identity = hashlib.sha256("".join(s.recording or s.source for s in replayed.signals).encode()).hexdigest()[:32]
    rec = rr.RecordingStream("physident", recording_id=identity, send_properties=False)
    rec.save(path)
    rec.send_recording_name(f"{robot.name}: replay")
    clock = np.concatenate([s.time - s.origin + o for s, o in zip(replayed.signals, offsets, strict=True)])
    points = log_arm(rec, "measured", robot, clock, np.concatenate([s.q for s in replayed.signals]), meshes)
    measured = windows.q[order, -1]
    for (name, colour), trace in zip(ARMS, replayed.traces, strict=False):
        away = np.clip(np.nan_to_num(trace.q[order, -1] - measured, nan=np.pi), -np.pi, np.pi)
        log_arm(rec, name, robot, arrival[order], measured + away, meshes)
        tint(rec, name, robot, float(arrival[order[0]]), [*rgb(colour), ALPHA], meshes)
        ends = [tool_path(robot, *link_poses(robot, q)) for q in (measured + away, measured)]
        distance = 1e3 * np.linalg.norm(ends[0] - ends[1], axis=1)
        curve(rec, f"error/tool/{name}", arrival[order], distance, f"{name} [mm]", colour)
        for j in range(robot.n):
            curve(rec, f"error/joint_{j + 1}/{name}", arrival[order], 1e3 * away[:, j], f"{name} [mrad]", colour)
    rec.log("summary", rr.TextDocument(f"```\n{replayed.replay!r}\n```", media_type="text/markdown"), static=True)
    title = f"measured arm, and simulations {horizon:g} s ahead"
    camera = Camera.around(points, title)
    eye = rrb.EyeControls3D(
        position=camera.centre + 1.6 * camera.reach * np.array([0.7, -0.95, 0.45]), look_target=camera.centre
    )
    joints = [rrb.TimeSeriesView(origin=f"error/joint_{j + 1}", name=f"joint {j + 1}") for j in range(robot.n)]
    scene = rrb.Spatial3DView(
        origin="/", contents=["measured/**", "before/**", "after/**"], name=title, eye_controls=eye
    )
    right = rrb.Vertical(
        rrb.TimeSeriesView(origin="error/tool", name="tool"), rrb.Tabs(*joints, rrb.TextDocumentView(origin="summary"))
    )
    rec.send_blueprint(rrb.Blueprint(rrb.Horizontal(scene, right, column_shares=[3, 2]), collapse_panels=True))
    rec.flush()
    rec.disconnect()
