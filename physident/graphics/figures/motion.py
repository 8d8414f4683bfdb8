"""A planned motion as a figure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from physident.graphics import style

if TYPE_CHECKING:
    from physident.excitation.motion.motion import Motion

SAMPLES = 1000


def plot_motion(motion: Motion, path: str | Path) -> None:
    """Draw position, velocity and acceleration of each joint over time [s]: a row a quantity, a line a joint."""
    states = motion.states(np.linspace(0, motion.duration, SAMPLES))
    fig, axes = style.figure(3, 1, sharex=True)
    channels = (("position [rad]", states.q), ("velocity [rad/s]", states.v), ("acceleration [rad/s$^2$]", states.a))
    for axis, (label, values) in zip(axes[:, 0], channels, strict=True):
        for j in range(motion.n):
            axis.plot(states.time, values[:, j], color=style.JOINTS[j % len(style.JOINTS)], label=f"{j + 1}")
        axis.set_ylabel(label)
    axes[-1, 0].set_xlabel("time [s]")
    fig.legend(*axes[0, 0].get_legend_handles_labels(), title="joint", loc="outside right upper", fontsize=8)
    style.save(fig, path)
