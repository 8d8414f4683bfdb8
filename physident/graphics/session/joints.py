"""The curves of each joint: measured and predicted torque, residual, motion, the contribution of every effect, charts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from physident.diagnosis.result.wording import EXTENDED
from physident.graphics import style
from physident.graphics.session import chart
from physident.graphics.session.data import Prediction, SessionData
from physident.graphics.session.log import curve, path_part
from physident.robots.robot import Robot

if TYPE_CHECKING:
    import rerun as rr


def log_joints(rec: rr.RecordingStream, data: SessionData, robot: Robot) -> None:
    """Log each joint's curves under ``joints/J``, its charts under ``charts/J`` (J from 1), and the legends."""
    models = model_colours([p.name for p in data.predictions])
    chart.log_legend(rec, "legend/models", {"measured": style.SESSION_MEASURED, **models})
    chart.log_legend(rec, "legend/motion", {"position": style.POSITION, "velocity": style.VELOCITY})
    if models:
        chart.log_legend(rec, "legend/residual", models)
    for p in data.predictions:
        chart.log_legend(
            rec, f"legend/effects/{path_part(p.name)}", {name: style.effect_colour(name) for name in p.effects}
        )
    for j in range(data.n):
        root = f"joints/{j + 1}"
        kind = robot.joints[j].kind
        curve(rec, f"{root}/torque/measured", data.time, data.measured[:, j], "measured", style.SESSION_MEASURED, 4.0)
        curve(rec, f"{root}/velocity", data.time, data.v[:, j], "velocity", style.VELOCITY)
        curve(rec, f"{root}/position", data.time, data.q[:, j], "position", style.POSITION)
        for p in data.predictions:
            colour = models[p.name]
            curve(rec, f"{root}/torque/predicted/{path_part(p.name)}", data.time, p.torque[:, j], p.name, colour)
            curve(rec, f"{root}/residual/{path_part(p.name)}", data.time, data.residual(p)[:, j], p.name, colour)
            _log_effects(rec, f"{root}/effects/{path_part(p.name)}", data, p, j)
        if data.predictions:
            _log_charts(rec, data, j, kind == "prismatic")


def model_colours(names: Sequence[str]) -> dict[str, str]:
    """The colour of each model: orange for the first one, blue for the extended model or the second one, then others."""
    order = [name for name in names if name != EXTENDED]
    if EXTENDED in names:
        order.insert(1, EXTENDED)
    return {name: style.MODELS[number % len(style.MODELS)] for number, name in enumerate(order)}


def effects_of(prediction: Prediction, joint: int) -> list[str]:
    """Names of the effects that contribute torque to a joint (from 0), in the model's order."""
    return [name for name, part in prediction.effects.items() if np.nan_to_num(part[:, joint]).any()]


def _log_effects(rec: rr.RecordingStream, root: str, data: SessionData, p: Prediction, j: int) -> None:
    for name in effects_of(p, j):
        curve(rec, f"{root}/{name}", data.time, p.effects[name][:, j], name, style.effect_colour(name))


def _log_charts(rec: rr.RecordingStream, data: SessionData, j: int, prismatic: bool) -> None:
    """Charts of the residual against velocity and position: points of the first model, a median line of each model."""
    first, colours = data.residual(data.predictions[0])[:, j], model_colours([p.name for p in data.predictions])
    length, effort = ("m", "N") if prismatic else ("rad", "N m")
    for name, x, unit in (("velocity", data.v[:, j], f"{length}/s"), ("position", data.q[:, j], length)):
        root = f"charts/{j + 1}/{name}"
        axes = chart.Axes.about(x[np.isfinite(first)], first)
        chart.log_axes(rec, root, axes, f"{name} [{unit}]", f"residual [{effort}]")
        chart.log_points(rec, f"{root}/points", axes, x, first, colours[data.predictions[0].name])
        for p in data.predictions:
            middle = chart.binned_median(x, data.residual(p)[:, j])
            chart.log_line(rec, f"{root}/median/{path_part(p.name)}", axes, *middle, colours[p.name])
        chart.log_cursor(rec, f"{root}/now", axes, data.time, x, first)
