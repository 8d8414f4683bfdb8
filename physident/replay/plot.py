"""A figure of a replay: the error of each joint over the horizon, of the model as it was and the extended one."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from physident.diagnosis.result.wording import AS_IT_WAS, EXTENDED
from physident.graphics import style
from physident.replay.replay import Replayed
from physident.robots.robot import Robot

LINES = ((AS_IT_WAS, style.AS_IT_WAS, 2.4), (EXTENDED, style.EXTENDED, 1.1))  # name, colour and width


def plot_replay(replayed: Replayed, robot: Robot, path: str | Path) -> None:
    """Draw the position error of each joint [mrad|mm] (RMS over the starts) over the time since the start [s].

    Raises InputError for a path without a known ending.
    """
    windows = replayed.windows
    fig, axes = style.figure(robot.n, sharex=True)
    for j, axis in enumerate(axes[:, 0]):
        for (label, colour, width), trace in zip(LINES, replayed.traces, strict=False):
            error = np.clip(np.nan_to_num(trace.q[..., j] - windows.q[..., j], nan=np.pi), -np.pi, np.pi)
            axis.plot(windows.clock, 1e3 * np.sqrt((error**2).mean(axis=0)), color=colour, label=label, linewidth=width)
        axis.set_ylabel(robot.joints[j].unit("mrad"))
        axis.set_title(f"joint {j + 1}, {robot.joint_names[j]}", fontsize=9, loc="left", parse_math=False)
    axes[0, 0].legend(ncols=2, loc="lower right", bbox_to_anchor=(1, 1), borderaxespad=0, frameon=False)
    axes[-1, 0].set_xlabel("time since the measured state [s]")
    fig.suptitle(replayed.replay.verdict, fontsize=10, x=0.01, ha="left", fontweight="bold", parse_math=False)
    style.save(fig, path)
