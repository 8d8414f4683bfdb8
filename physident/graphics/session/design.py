"""A planned motion before it is recorded, and the progress of its design."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from physident.graphics import style
from physident.graphics.plan import Plan, plan_markdown
from physident.graphics.scene import log_arm
from physident.graphics.session import chart
from physident.graphics.session.log import curve
from physident.robots.robot import Robot

if TYPE_CHECKING:
    import rerun as rr

Array = NDArray[np.float64]
RATE = 50.0  # Hz
LEGEND_ROW = 3


def log_design(rec: rr.RecordingStream, plan: Plan, robot: Robot, meshes: str | Path | None) -> Array:
    """Log a planned motion and its design under ``design``; returns points (P, 3) [m] on the arm along the motion."""
    import rerun as rr

    time, q, v, a = plan.motion.sample(RATE)
    colours = [*style.JOINTS[:-1], style.SESSION_MEASURED]  # grey for black
    names = {f"{j} {name}": colours[(j - 1) % len(colours)] for j, name in enumerate(robot.joint_names, 1)}
    chart.log_legend(rec, "legend/joints", names, LEGEND_ROW)
    for name, values in (("position", q), ("velocity", v), ("acceleration", a)):
        for j, (joint, colour) in enumerate(names.items()):
            curve(rec, f"design/{name}/{j + 1}", time, values[:, j], joint, colour)
    if plan.design:
        rec.log("design/limits", rr.TextDocument(plan_markdown(plan.design), media_type="text/markdown"), static=True)
    if plan.progress:
        _log_progress(rec, plan)
    return log_arm(rec, "design/robot", robot, time[::2], q[::2], meshes)


def _log_progress(rec: rr.RecordingStream, plan: Plan) -> None:
    """Log the condition number over the iterations of a design, and where IPOPT begins."""
    progress = np.array(plan.progress)
    iteration = np.arange(1.0, len(progress) + 1)
    axes = chart.Axes.about(iteration, progress, logarithmic=True)
    chart.log_axes(rec, "design/progress", axes, "iteration", "condition number")
    chart.log_line(rec, "design/progress/condition_number", axes, iteration, progress, style.OTHER)
    if 0 < plan.generations < len(progress):
        chart.log_mark(rec, "design/progress/ipopt", axes, plan.generations + 0.5, "IPOPT begins")
