"""Figures of the residuals of two models on the same recordings, one row a joint."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from physident.diagnosis.result.diagnosis import Diagnosis
from physident.diagnosis.result.findings import CurveBand
from physident.graphics import style
from physident.graphics.figures.draw import draw_residuals
from physident.recordings.recording import Recording
from physident.robots.robot import Robot
from physident.validation.comparison import Pair, contact_bands, predict_pair

HEAD_WIDTH = 110  # characters


def plot_residuals(
    pair: Pair,
    robot: Robot,
    path: str | Path,
    head: str = "",
    bands: Sequence[tuple[float, float]] = (),
    joints: Sequence[int] | None = None,
    curves: Sequence[CurveBand] = (),
) -> None:
    """Draw the residual [N m|N] of one model, or of the model as it was and the extended one, over time in motion [s].

    ``head`` is the title. ``bands`` (start, end) [s] on the time axis are shaded. ``joints`` (from 1) are drawn, all by
    default. Below them, each of ``curves`` is drawn with its band. Raises InputError for a path without a known ending.
    """
    shown = list(joints or range(1, robot.n + 1))
    fig, axes = style.figure(len(shown) + len(curves), sharex=not curves)
    units = robot.torque_units
    for axis, joint in zip(axes[:, 0], shown, strict=False):
        j = joint - 1
        draw_residuals(axis, pair, j)
        for start, end in bands:
            axis.axvspan(start, end, color="0.88", zorder=0)
        axis.set_ylabel(f"residual [{units[j]}]")
        sizes = [float(p.rms[j]) for p in pair.both]
        title = f"joint {joint}, {robot.joint_names[j]}: {_change(sizes, units[j])}"
        axis.set_title(title, fontsize=9, loc="left", parse_math=False)
    if head:
        text = "\n".join(textwrap.wrap(head, HEAD_WIDTH))
        fig.suptitle(text, fontsize=10, x=0.01, ha="left", fontweight="bold", parse_math=False)
    axes[0, 0].legend(ncols=2, loc="lower right", bbox_to_anchor=(1, 1), borderaxespad=0, frameon=False)
    axes[len(shown) - 1, 0].set_xlabel("time in motion [s]")
    for axis, curve in zip(axes[len(shown) :, 0], curves, strict=True):
        _draw_curve(axis, curve, units[curve.joint - 1])
    style.save(fig, path)


def plot_diagnosis(d: Diagnosis, recordings: Sequence[Recording], path: str | Path) -> None:
    """Draw the residual of recordings before and after a diagnosis, with the answer as title and contacts as bands."""
    after = None if d.estimate is None else d.estimate.model
    pair = predict_pair(d.model, after, recordings, d.filter, d.drive_gains)
    bands = contact_bands(after, pair.before, recordings)
    head = f"{d.headline} {d.remainder}"
    curves = [curve for finding in d.findings if finding.grade != "hint" for curve in finding.curves]
    plot_residuals(pair, d.model.robot, path, head, bands, curves=curves)


def _draw_curve(axis: Any, curve: CurveBand, unit: str) -> None:
    """A learned curve with its 95 % band."""
    axis.fill_between(curve.x, curve.low, curve.high, color="0.85", linewidth=0)
    axis.plot(curve.x, curve.torque, color=style.OTHER)
    axis.axhline(0.0, color="0.6", linewidth=0.8)
    axis.set_ylabel(f"learned [{unit}]")
    axis.set_xlabel(f"{curve.quantity} [{curve.unit}]")
    axis.set_title(f"joint {curve.joint}: learned over {curve.quantity}, with its 95 % band", fontsize=9, loc="left")


def _change(sizes: Sequence[float], unit: str) -> str:
    if len(sizes) == 1:
        return f"RMS {sizes[0]:.3g} {unit}"
    percent = round(100 * (sizes[1] / sizes[0] - 1)) if sizes[0] > 0 else 0
    return f"RMS {sizes[0]:.3g} to {sizes[1]:.3g} {unit} ({f'{percent:+d} %' if percent else 'unchanged'})"
