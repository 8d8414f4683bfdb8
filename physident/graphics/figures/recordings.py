"""Figures of recordings, and of a model's predictions against them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import get_args

import numpy as np

from physident.graphics import style
from physident.graphics.figures.draw import Channel, draw_recording, draw_torque
from physident.recordings.recording import Recording
from physident.validation.predictions import Predictions


def plot_predictions(
    p: Predictions, joints: Sequence[str], path: str | Path, units: Sequence[str] | None = None
) -> None:
    """Draw measured torque, predicted torque and the residual over time [s]: a row a joint, recordings end to end.

    ``units`` are those of the joints' torques, N m by default. Raises InputError for a path without a known ending.
    """
    fig, axes = style.figure(len(joints), sharex=True)
    for j, (axis, name) in enumerate(zip(axes[:, 0], joints, strict=True)):
        draw_torque(axis, p, j)
        error = 100 * np.linalg.norm(p.residual[:, j]) / np.linalg.norm(p.measured[:, j])
        axis.set_ylabel(f"torque [{units[j] if units else 'N m'}]")
        axis.set_title(f"joint {j + 1}, {name}: error {error:.1f} %", fontsize=9, loc="left", parse_math=False)
    fig.legend(*axes[0, 0].get_legend_handles_labels(), ncols=3, loc="outside upper right")
    axes[-1, 0].set_xlabel("time in motion [s]")
    style.save(fig, path)


def plot_recordings(recordings: Sequence[Recording], path: str | Path) -> None:
    """Draw position [rad], velocity [rad/s] and effort over time [s]: a row a recording, a line a joint."""
    fig, axes = style.figure(len(recordings), 3, size=(4.5, 2.4))
    for row, r in zip(axes, recordings, strict=True):
        for axis, channel in zip(row, get_args(Channel), strict=True):
            draw_recording(axis, r, channel)
        row[0].set_title(Path(r.source).name, fontsize=9, loc="left", parse_math=False)
    fig.legend(*axes[0, 0].get_legend_handles_labels(), title="joint", loc="outside right upper", fontsize=8)
    style.save(fig, path)
