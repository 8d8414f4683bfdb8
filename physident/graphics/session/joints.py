"""The curves of each joint: measured and predicted torque, residual, motion, the contribution of every effect, charts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from physident.diagnosis.result.wording import EXTENDED
from physident.effects.catalogue import effect_label
from physident.graphics import style
from physident.graphics.session import chart
from physident.graphics.session.data import Prediction, SessionData
from physident.graphics.session.log import curve, path_part
from physident.robots.robot import Robot

if TYPE_CHECKING:
    import rerun as rr

# Curves that coincide lie in one another: the measured one is the widest, and every later model is drawn narrower and above
WIDEST, WIDTHS = 6.0, (3.2, 1.2)
REMAINDER, REMAINDER_WIDTH = "remainder: no effect explains it", 2.0
INNER = 0.995  # of the points of a chart are in its frame; those beyond are drawn at its edge


def log_joints(
    rec: rr.RecordingStream, data: SessionData, robot: Robot, cover: tuple[float, int] | None = None
) -> None:
    """Log each joint's curves under ``joints/J``, its charts under ``charts/J`` (J from 1), and the legends.

    ``cover`` is an instant [s] before the first, and the row that the marks of the charts show then.
    """
    models = model_colours([p.name for p in data.predictions])
    chart.log_legend(rec, "legend/models", {"measured": style.SESSION_MEASURED, **models})
    chart.log_legend(rec, "legend/motion", {"position": style.POSITION, "velocity": style.VELOCITY})
    if models:
        chart.log_legend(rec, "legend/residual", models)
    for p in data.predictions:
        effects = {effect_label(name): style.effect_colour(name) for name in p.effects}
        legend = effects | {REMAINDER: style.SESSION_MEASURED}
        chart.log_legend(rec, f"legend/effects/{path_part(p.name)}", legend)
    for j in range(data.n):
        root = f"joints/{j + 1}"
        kind = robot.joints[j].kind
        curve(
            rec, f"{root}/torque/measured", data.time, data.measured[:, j], "measured", style.SESSION_MEASURED, WIDEST
        )
        curve(rec, f"{root}/velocity", data.time, data.v[:, j], "velocity", style.VELOCITY)
        curve(rec, f"{root}/position", data.time, data.q[:, j], "position", style.POSITION)
        for place, p in enumerate(data.predictions):
            part, look = model_path(place, p.name), (p.name, models[p.name], WIDTHS[min(place, len(WIDTHS) - 1)])
            curve(rec, f"{root}/torque/predicted/{part}", data.time, p.torque[:, j], *look)
            curve(rec, f"{root}/residual/{part}", data.time, data.residual(p)[:, j], *look)
            _log_effects(rec, f"{root}/effects/{path_part(p.name)}", data, p, j)
        if data.predictions:
            _log_charts(rec, data, j, kind == "prismatic", cover)


def model_colours(names: Sequence[str]) -> dict[str, str]:
    """The colour of each model: orange for the first one, blue for the extended model or the second one, then others."""
    order = [name for name in names if name != EXTENDED]
    if EXTENDED in names:
        order.insert(1, EXTENDED)
    return {name: style.MODELS[number % len(style.MODELS)] for number, name in enumerate(order)}


def effects_of(prediction: Prediction, joint: int) -> list[str]:
    """Names of the effects that contribute torque to a joint (from 0), in the model's order."""
    return [name for name, part in prediction.effects.items() if np.nan_to_num(part[:, joint]).any()]


def model_path(place: int, name: str) -> str:
    """A model's part of a path: the viewer draws later paths over earlier ones, so a model's place (from 0) comes first."""
    return path_part(f"{place + 1}_{name}")


def _log_effects(rec: rr.RecordingStream, root: str, data: SessionData, p: Prediction, j: int) -> None:
    """The torque of each effect, and what none of them explains, such as a push that has no name."""
    residual = data.residual(p)[:, j]
    curve(rec, f"{root}/0_remainder", data.time, residual, REMAINDER, style.SESSION_MEASURED, REMAINDER_WIDTH)
    for name in effects_of(p, j):
        curve(rec, f"{root}/{name}", data.time, p.effects[name][:, j], effect_label(name), style.effect_colour(name))


def _log_charts(
    rec: rr.RecordingStream, data: SessionData, j: int, prismatic: bool, cover: tuple[float, int] | None
) -> None:
    """Charts of the residual against velocity and position: points of the first model, a median line of each model."""
    first, colours = data.residual(data.predictions[0])[:, j], model_colours([p.name for p in data.predictions])
    length, effort = ("m", "N") if prismatic else ("rad", "N m")
    for name, x, unit in (("velocity", data.v[:, j], f"{length}/s"), ("position", data.q[:, j], length)):
        root = f"charts/{j + 1}/{name}"
        axes = chart.Axes.about(x[np.isfinite(first)], first, inner=INNER)
        chart.log_axes(rec, root, axes, f"{name} [{unit}]", f"residual [{effort}]")
        chart.log_points(rec, f"{root}/points", axes, x, first, colours[data.predictions[0].name])
        for place, p in enumerate(data.predictions):
            middle, width = chart.binned_median(x, data.residual(p)[:, j]), WIDTHS[min(place, len(WIDTHS) - 1)]
            path = f"{root}/median/{model_path(place, p.name)}"
            chart.log_line(rec, path, axes, *middle, colours[p.name], 1.5 * width, place)
        shown = slice(None) if cover is None else np.append(cover[1], np.arange(len(x)))
        clock = data.time if cover is None else np.append(cover[0], data.time)
        chart.log_cursor(rec, f"{root}/now", axes, clock, x[shown], first[shown])
