"""The curves of each joint: measured and predicted torque, residual, motion, the contribution of every effect, charts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from physident.graphics import style
from physident.graphics.session import chart
from physident.graphics.session.data import Prediction, SessionData
from physident.graphics.session.log import curve, path_part
from physident.robots.robot import Robot

if TYPE_CHECKING:
    import rerun as rr


def log_joints(rec: rr.RecordingStream, data: SessionData, robot: Robot) -> None:
    """Log each joint's curves under ``joints/J``, its charts under ``charts/J`` (J from 1), and the legends."""
    models = {p.name: model_colour(i) for i, p in enumerate(data.predictions)}
    chart.log_legend(rec, "legend/models", {"measured": style.SESSION_MEASURED, **models})
    chart.log_legend(rec, "legend/motion", {"position": style.MODELS[1], "velocity": style.MODELS[0]})
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
        curve(rec, f"{root}/velocity", data.time, data.v[:, j], "velocity", style.MODELS[0])
        curve(rec, f"{root}/position", data.time, data.q[:, j], "position", style.MODELS[1])
        for number, p in enumerate(data.predictions):
            colour = model_colour(number)
            curve(rec, f"{root}/torque/predicted/{path_part(p.name)}", data.time, p.torque[:, j], p.name, colour)
            curve(rec, f"{root}/residual/{path_part(p.name)}", data.time, data.residual(p)[:, j], p.name, colour)
            _log_effects(rec, f"{root}/effects/{path_part(p.name)}", data, p, j)
        if data.predictions:
            _log_charts(rec, data, j, kind == "prismatic")


def model_colour(number: int) -> str:
    """The colour of a model by its number (from 0)."""
    return style.MODELS[number % len(style.MODELS)]


def effects_of(prediction: Prediction, joint: int) -> list[str]:
    """Names of the effects that contribute torque to a joint (from 0), in the model's order."""
    return [name for name, part in prediction.effects.items() if np.nan_to_num(part[:, joint]).any()]


def _log_effects(rec: rr.RecordingStream, root: str, data: SessionData, p: Prediction, j: int) -> None:
    for name in effects_of(p, j):
        curve(rec, f"{root}/{name}", data.time, p.effects[name][:, j], name, style.effect_colour(name))


def _log_charts(rec: rr.RecordingStream, data: SessionData, j: int, prismatic: bool) -> None:
    """Charts of the residual against velocity and position: points of the first model, a median line of each model."""
    first = data.residual(data.predictions[0])[:, j]
    length, effort = ("m", "N") if prismatic else ("rad", "N m")
    for name, x, unit in (("velocity", data.v[:, j], f"{length}/s"), ("position", data.q[:, j], length)):
        root = f"charts/{j + 1}/{name}"
        axes = chart.Axes.about(x[np.isfinite(first)], first)
        chart.log_axes(rec, root, axes, f"{name} [{unit}]", f"residual [{effort}]")
        chart.log_points(rec, f"{root}/points", axes, x, first, model_colour(0))
        for number, p in enumerate(data.predictions):
            middle = chart.binned_median(x, data.residual(p)[:, j])
            chart.log_line(rec, f"{root}/median/{path_part(p.name)}", axes, *middle, model_colour(number))
        chart.log_cursor(rec, f"{root}/now", axes, data.time, x, first)
