"""Curves drawn into an ``Axes`` of the user's own figure: recordings, predictions and residuals."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from physident.diagnosis.result.wording import AS_IT_WAS, EXTENDED
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.graphics import style
from physident.recordings.load import Recordings
from physident.recordings.recording import Recording
from physident.validation.comparison import Pair
from physident.validation.predictions import Predictions, predict

Channel = Literal["position", "velocity", "effort"]
# name, colour and width: where both coincide, the narrow second line lies in the wide first one
LINES = ((AS_IT_WAS, style.AS_IT_WAS, 1.8), (EXTENDED, style.EXTENDED, 0.9))


def draw_recording(axes: Any, recording: Recording, channel: Channel = "position") -> None:
    """Draw the position [rad|m], the velocity [rad/s|m/s] or the effort [N m|N|A] of all joints over time [s] into ``axes``.

    A velocity that was not recorded is the derivative of the positions.
    """
    _check_axes(axes)
    r = recording
    if channel == "velocity":
        values = r.dq if r.dq is not None else np.gradient(r.q, r.time, axis=0)
    else:
        values = r.q if channel == "position" else r.effort
    unit = "N m" if r.effort_kind == "torque" else "A"
    labels = {"position": "position [rad]", "velocity": "velocity [rad/s]", "effort": f"{r.effort_kind} [{unit}]"}
    for j in range(r.n):
        colour = style.JOINTS[j % len(style.JOINTS)]
        axes.plot(r.time - r.time[0], values[:, j], color=colour, label=f"{j + 1}", linewidth=0.8)
    axes.set_ylabel(labels[channel])
    axes.set_xlabel("time [s]")


def draw_prediction(axes: Any, estimate: Estimate, recordings: Recordings, joint: int) -> None:
    """Draw measured torque, predicted torque and the residual [N m|N] of a ``joint`` (from 1) over time in motion [s] into
    ``axes``; recordings follow one another. Raises InputError for a joint that the robot does not have, and as ``predict``."""
    _check_axes(axes)
    _check_joint(estimate, joint)
    draw_torque(axes, predict(estimate, recordings), joint - 1)
    axes.set_title(f"joint {joint}, {estimate.model.robot.joint_names[joint - 1]}", loc="left", parse_math=False)
    axes.set_ylabel("torque")
    axes.set_xlabel("time in motion [s]")


def draw_residual(axes: Any, before: Estimate, after: Estimate, recordings: Recordings, joint: int) -> None:
    """Draw the residual torque [N m|N] of two models for a ``joint`` (from 1) over time in motion [s] into ``axes``.

    ``before`` is the model as it was, ``after`` the extended one; both see the filter of the first. Raises InputError for a joint
    that the robot does not have, and as ``predict``.
    """
    _check_axes(axes)
    _check_joint(before, joint)
    if before.model.robot.n != after.model.robot.n:
        raise InputError(
            f"the models have {before.model.robot.n} and {after.model.robot.n} joints; expected the same robot"
        )
    pair = Pair(predict(before, recordings), predict(after.with_cutoff(before.filter.cutoff), recordings))
    draw_residuals(axes, pair, joint - 1)
    axes.set_title(f"joint {joint}, {before.model.robot.joint_names[joint - 1]}", loc="left", parse_math=False)
    axes.set_ylabel("residual")
    axes.set_xlabel("time in motion [s]")


def draw_torque(axes: Any, p: Predictions, j: int) -> None:
    """The measured and the predicted torque of a joint (from 0), the residual, and the borders of recordings."""
    measured, predicted, time = p.measured[:, j], p.predicted[:, j], np.arange(len(p.time)) / p.rate
    axes.plot(time, measured, color=style.MEASURED, label="measured", linewidth=2.0)
    axes.plot(time, predicted, color=style.AS_IT_WAS, label="predicted", linewidth=1.0)
    axes.plot(time, measured - predicted, color=style.OTHER, label="residual", linewidth=0.8)
    _draw_borders(axes, p)


def draw_residuals(axes: Any, pair: Pair, j: int) -> None:
    """The residual of a joint (from 0) of one model or of two, and the borders of recordings."""
    time = np.arange(len(pair.before.time)) / pair.before.rate
    for p, (label, colour, width) in zip(pair.both, LINES, strict=False):
        axes.plot(time, p.residual[:, j], color=colour, label=label, linewidth=width)
    _draw_borders(axes, pair.before)


def _draw_borders(axes: Any, p: Predictions) -> None:
    for border in np.flatnonzero(np.diff(p.recording)) + 1:
        axes.axvline(border / p.rate, color="0.6", linewidth=0.8, linestyle=":")


def _check_axes(axes: Any) -> None:
    if not hasattr(axes, "axvline"):
        raise InputError(f"axes is {type(axes).__name__}, expected the Axes of a matplotlib figure")


def _check_joint(estimate: Estimate, joint: int) -> None:
    if not 1 <= joint <= estimate.model.robot.n:
        raise InputError(f"joint is {joint}, expected a number from 1 to {estimate.model.robot.n}")
