"""A session of a replay for the rerun viewer: the measured arm, and where each model's simulation expects it."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.result.wording import AS_IT_WAS, EXTENDED
from physident.graphics import style
from physident.graphics.labels import VIEW_FROM
from physident.graphics.scene import link_poses, log_arm, tint, tool_path
from physident.graphics.session.blueprint import Camera
from physident.graphics.session.log import TIMELINE, curve, duration, rgb
from physident.graphics.session.write import COVER, check_session_path
from physident.outputs import write_with
from physident.replay.replay import Replayed
from physident.replay.score import Replay
from physident.robots.robot import Robot

Array = NDArray[np.float64]
# path, name, colour and width of curves: where both coincide, the second one lies in the first
ARMS = (("as_it_was", AS_IT_WAS, style.MODELS[0], 2.6), ("extended", EXTENDED, style.MODELS[1], 1.1))
ALPHA = 90  # of 255: a simulated arm is transparent
TOOL = 0.008  # m: radius of the tool's point, a third of which is that of the arrow to where it is simulated
NEAR = 0.25  # of the distance of the whole arm
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

    windows, horizon = replayed.windows, float(replayed.windows.clock[-1])
    offsets = np.cumsum([0.0, *(s.time[-1] - s.origin + PAUSE for s in replayed.signals)])[:-1]
    arrival = windows.start + offsets[windows.recording] + horizon
    order = np.argsort(arrival)
    identity = hashlib.sha256("".join(s.recording or s.source for s in replayed.signals).encode()).hexdigest()[:32]
    rec = rr.RecordingStream("physident", recording_id=identity, send_properties=False)
    rec.save(path)
    rec.send_recording_name(f"{robot.name}: replay")
    clock = np.concatenate([s.time - s.origin + o for s, o in zip(replayed.signals, offsets, strict=True)])
    q, measured, instant = np.concatenate([s.q for s in replayed.signals]), windows.q[order, -1], arrival[order]
    places = tool_path(robot, *link_poses(robot, measured))
    simulated = [
        measured + np.clip(np.nan_to_num(trace.q[order, -1] - measured, nan=np.pi), -np.pi, np.pi)
        for trace in replayed.traces
    ]
    gaps = [tool_path(robot, *link_poses(robot, one)) - places for one in simulated]
    worst = int(np.argmax(np.linalg.norm(gaps[0], axis=1)))  # the session opens there
    points = log_arm(rec, "measured", robot, clock, q, meshes, cover=(COVER, measured[worst]))
    rows, covered = np.append(worst, np.arange(len(instant))), np.append(COVER, instant)
    for (arm, name, colour, width), one, gap in zip(ARMS, simulated, gaps, strict=False):
        log_arm(rec, arm, robot, instant, one, meshes, cover=(COVER, one[worst]))
        tint(rec, arm, robot, COVER, [*rgb(colour), ALPHA], meshes)
        rec.log(f"{arm}/tool", rr.Points3D.from_fields(colors=[rgb(colour)], radii=[TOOL]), static=True)
        arrows = rr.Arrows3D.columns(vectors=gap[rows], origins=places[rows])
        rec.send_columns(f"{arm}/gap", [duration(covered)], arrows)
        rec.log(f"{arm}/gap", rr.Arrows3D.from_fields(colors=[rgb(colour)], radii=[TOOL / 3]), static=True)
        distance = 1e3 * np.linalg.norm(gap, axis=1)
        curve(rec, f"error/tool/{arm}", instant, distance, f"{name} [mm]", colour, width)
        for j, joint in enumerate(robot.joints):
            away = 1e3 * (one - measured)[:, j]
            curve(rec, f"error/joint_{j + 1}/{arm}", instant, away, f"{name} [{joint.unit('mrad')}]", colour, width)
    rec.log("summary", rr.TextDocument(_summary(replayed.replay), media_type="text/markdown"), static=True)
    camera = Camera.around(
        points, f"measured arm, and simulations {horizon:g} s ahead; opens as at {instant[worst]:.1f} s"
    )
    rec.send_blueprint(_blueprint(replayed.replay, robot, camera))
    rec.flush()
    rec.disconnect()


def _blueprint(result: Replay, robot: Robot, camera: Camera) -> Any:
    """The arms, the same near the tool, and the summary on the left; the errors of tool and joints on the right."""
    import rerun.blueprint as rrb

    # of a simulated arm only what differs from the measured one: base, names and the path of the tool stand there already
    same = [f"- {arm}/{part}" for arm, *_ in ARMS for part in ("base/**", "tool_path", "names")]
    contents = ["measured/**", *(f"{arm}/**" for arm, *_ in ARMS), *same]
    reach = camera.reach * VIEW_FROM
    whole, near = (
        rrb.Spatial3DView(
            origin="/",
            contents=shown,
            name=title,
            eye_controls=rrb.EyeControls3D(
                position=camera.centre + far * reach,
                look_target=camera.centre,
                eye_up=[0, 0, 1],
                tracking_entity=follow,
            ),
        )
        for title, far, follow, shown in (
            (camera.title, 1.0, None, contents),
            ("at the tool", NEAR, "/measured/tool", [*contents, "- measured/names", "- measured/tool_path"]),
        )
    )
    joints = [
        rrb.TimeSeriesView(
            origin=f"error/joint_{j + 1}",
            name=f"{j + 1} {joint.name} [{joint.unit('mrad')}]",
            plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=False),
        )
        for j, joint in enumerate(robot.joints)
    ]
    legend = rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=True)
    tool = rrb.TimeSeriesView(origin="error/tool", name="distance of the tools [mm]", plot_legend=legend)
    summary = rrb.TextDocumentView(origin="summary", name="summary")
    left = rrb.Vertical(rrb.Horizontal(whole, near, column_shares=[3, 2]), summary, row_shares=[3, 2])
    right = rrb.Vertical(tool, rrb.Grid(*joints, grid_columns=2), row_shares=[1, 2])
    return rrb.Blueprint(
        rrb.Horizontal(left, right, column_shares=[4, 3]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="paused"),
    )


def _summary(result: Replay) -> str:
    """The replay's errors as a table in Markdown."""
    scores = [result.before] if result.after is None else [result.before, result.after]
    parts = (
        ("position [mrad]", 1e3, "position"),
        ("velocity [mrad/s]", 1e3, "velocity"),
        ("torque added [N m]", 1.0, "torque"),
    )
    rows = ["| joint | " + " | ".join(title for title, _, _ in parts) + " |", "|---" * 4 + "|"]
    for j, name in enumerate(result.joints):
        cells = [" → ".join(f"{k * getattr(score, key)[j]:.3g}" for score in scores) for _, k, key in parts]
        rows.append(f"| {j + 1} {_plain(name)} | " + " | ".join(cells) + " |")
    stated = [f"- {_plain(text)}" for text in scores[-1].stated]
    kind = f"{AS_IT_WAS} → {EXTENDED}" if result.after is not None else "one model"
    how = f"Errors ({kind}) over {result.starts} starts; torque added by {result.controller}."
    return "\n".join(
        [
            f"**{result.verdict}**",
            "",
            how,
            *(["", result.units] if result.units else []),
            "",
            *rows,
            "",
            *(["Held otherwise than in the model, or not at all:", "", *stated] if stated else []),
        ]
    )


def _plain(text: str) -> str:
    """A text that Markdown shows as it is, in a table too."""
    return re.sub(r"([\\`*|<>\[\]])", r"\\\1", " ".join(text.split()))
