"""A designed motion before it is recorded, and how its design went on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from physident.robots.robot import Robot
from physident.view import style
from physident.view.plan import Plan, plan_words
from physident.view.scene import log_arm
from physident.view.session import chart
from physident.view.session.log import curve

if TYPE_CHECKING:
    import rerun as rr

Array = NDArray[np.float64]
RATE = 50.0  # Hz
LEGEND_ROW = 3


def log_design(rec: rr.RecordingStream, plan: Plan, robot: Robot, meshes: str | Path | None) -> Array:
    """Log a planned motion and what is known of its design under ``design``; returns where the arm has been (P, 3) [m]."""
    import rerun as rr

    time, q, v, a = plan.motion.sample(RATE)
    colours = [*style.JOINTS[:-1], style.SESSION_MEASURED]  # grey for black
    names = {f"{j} {name}": colours[(j - 1) % len(colours)] for j, name in enumerate(robot.joint_names, 1)}
    chart.log_legend(rec, "legend/joints", names, LEGEND_ROW)
    for name, values in (("position", q), ("velocity", v), ("acceleration", a)):
        for j, (joint, colour) in enumerate(names.items()):
            curve(rec, f"design/{name}/{j + 1}", time, values[:, j], joint, colour)
    if plan.design:
        rec.log("design/limits", rr.TextDocument(plan_words(plan.design), media_type="text/markdown"), static=True)
    if plan.progress:
        _log_progress(rec, plan)
    return log_arm(rec, "design/robot", robot, time[::2], q[::2], meshes)


def _log_progress(rec: rr.RecordingStream, plan: Plan) -> None:
    """Log the condition number over the iterations of a design, and which of them are generations."""
    progress = np.array(plan.progress)
    iteration = np.arange(1.0, len(progress) + 1)
    axes = chart.Axes.about(iteration, progress, logarithmic=True)
    chart.log_axes(rec, "design/progress", axes, "iteration", "condition number")
    chart.log_line(rec, "design/progress/condition_number", axes, iteration, progress, style.MODELS[0])
    if 0 < plan.generations < len(progress):
        chart.log_mark(rec, "design/progress/ipopt", axes, plan.generations + 0.5, "IPOPT begins")
