"""Figures of recordings, and of a model's predictions against them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from physident.graphics import style
from physident.recordings.recording import Recording
from physident.validation.predictions import Predictions


def plot_predictions(
    p: Predictions, joints: Sequence[str], path: str | Path, units: Sequence[str] | None = None
) -> None:
    """Draw measured torque, predicted torque and their difference over time [s]: a row a joint, recordings end to end.

    ``units`` are those of the joints' torques, N m by default. Raises InputError for a path without a known ending.
    """
    fig, axes = style.figure(len(joints), sharex=True)
    time = np.arange(len(p.time)) / p.rate
    borders = time[np.flatnonzero(np.diff(p.recording)) + 1]
    for j, (axis, name) in enumerate(zip(axes[:, 0], joints, strict=True)):
        measured, predicted = p.measured[:, j], p.predicted[:, j]
        axis.plot(time, measured, color=style.MEASURED, label="measured")
        axis.plot(time, predicted, color=style.AS_IT_WAS, label="predicted")
        axis.plot(time, measured - predicted, color=style.OTHER, label="difference", linewidth=0.8)
        for border in borders:
            axis.axvline(border, color="0.6", linewidth=0.8, linestyle=":")
        error = 100 * np.linalg.norm(measured - predicted) / np.linalg.norm(measured)
        axis.set_ylabel(f"torque [{units[j] if units else 'N m'}]")
        axis.set_title(f"joint {j + 1}, {name}: error {error:.1f} %", fontsize=9, loc="left", parse_math=False)
    fig.legend(*axes[0, 0].get_legend_handles_labels(), ncols=3, loc="outside upper right")
    axes[-1, 0].set_xlabel("time in motion [s]")
    style.save(fig, path)


def plot_recordings(recordings: Sequence[Recording], path: str | Path) -> None:
    """Draw position [rad], velocity [rad/s] and effort over time [s]: a row a recording, a line a joint."""
    fig, axes = style.figure(len(recordings), 3, size=(4.5, 2.4))
    for row, r in zip(axes, recordings, strict=True):
        time = r.time - r.time[0]
        velocity = r.dq if r.dq is not None else np.gradient(r.q, r.time, axis=0)
        unit = "N m" if r.effort_kind == "torque" else "A"
        channels = (("position [rad]", r.q), ("velocity [rad/s]", velocity), (f"{r.effort_kind} [{unit}]", r.effort))
        for axis, (label, values) in zip(row, channels, strict=True):
            for j in range(r.n):
                axis.plot(
                    time, values[:, j], color=style.JOINTS[j % len(style.JOINTS)], label=f"{j + 1}", linewidth=0.8
                )
            axis.set_ylabel(label)
            axis.set_xlabel("time [s]")
        row[0].set_title(Path(r.source).name, fontsize=9, loc="left", parse_math=False)
    fig.legend(*axes[0, 0].get_legend_handles_labels(), title="joint", loc="outside right upper", fontsize=8)
    style.save(fig, path)
