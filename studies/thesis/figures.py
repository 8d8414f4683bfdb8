"""The figures: trajectories, torques of each model per joint, manipulability."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

import physident as pid
from physident.graphics.style import AS_IT_WAS, EXTENDED, MEASURED, RESIDUAL, figure, save
from physident.identifiability.manipulability import SINGULAR, measure_manipulability
from studies.thesis.models import Compared
from studies.thesis.published import RATE
from studies.thesis.scores import FILTER, filtered

FOLDER = Path(__file__).parent
LIMITS = {"position [rad]": 2 * np.pi, "velocity [rad/s]": np.pi, "acceleration [rad/s²]": np.pi}


def trajectories(robot: pid.Robot, motions: Mapping[str, pid.Trajectory]) -> None:
    """Position, velocity and acceleration of every joint over one period (the thesis' figures 4.3-4.8)."""
    fig, axes = figure(robot.n, 3, size=(3.8, 1.55), sharex=True)
    for name, colour in (("thesis", RESIDUAL), ("designed", AS_IT_WAS)):
        time, *states = motions[name].sample(RATE)
        inside = time <= 1 / motions[name].base_frequency
        for column, values in enumerate(states):
            for j in range(robot.n):
                axes[j, column].plot(time[inside], values[inside, j], color=colour, label=name)
    for column, (label, limit) in enumerate(LIMITS.items()):
        for j in range(robot.n):
            axes[j, column].set_title(f"joint {j + 1}", fontsize=9, loc="left")
            if column:
                for side in (-limit, limit):
                    axes[j, column].axhline(side, color="0.5", linewidth=0.8, linestyle=":")
        axes[0, column].annotate(label, (0, 1.3), xycoords="axes fraction", fontweight="bold")
        axes[-1, column].set_xlabel("time [s]")
    fig.legend(*axes[0, 0].get_legend_handles_labels(), ncols=2, loc="outside lower center")
    save(fig, FOLDER / "trajectories.png")


def torques(found: Compared, way: str) -> None:
    """Torque of every joint on the validation trajectory: left as the thesis shows it, right the whole arm."""
    n = found.validation.torque.shape[1]
    fig, axes = figure(n, 2, size=(5.6, 1.75), sharex=True)
    row = np.arange(len(filtered(found.validation.true)))
    time = (row + FILTER.delay(RATE)) * FILTER.decimation(RATE) / RATE
    for j in range(n):
        for column, ways in enumerate((("thesis, halves",), ("thesis, whole arm", way))):
            axis = axes[j, column]
            measured = filtered(found.measured(ways[0]).torque)[:, j]
            axis.plot(time, measured, color=MEASURED, label="reference", linewidth=1.6)
            for name, colour, style in zip(ways, (RESIDUAL, EXTENDED), ("-", "--"), strict=False):
                axis.plot(time, filtered(found.predicted[name])[:, j], style, color=colour, label=_legend(name))
            errors = ", ".join(f"{_legend(name)} {_percent(found.error(name)[j])}" for name in ways)
            axis.set_title(f"joint {j + 1}: {errors}", fontsize=8, loc="left")
        axes[j, 0].set_ylabel("torque [N m]")
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    axes[0, 0].annotate("two robots of three joints", (0, 1.3), xycoords="axes fraction", fontweight="bold")
    axes[0, 1].annotate("one arm of six joints", (0, 1.3), xycoords="axes fraction", fontweight="bold")
    fig.legend(*axes[0, 1].get_legend_handles_labels(), ncols=3, loc="outside lower center")
    save(fig, FOLDER / f"model_{found.model}.png")


def _legend(way: str) -> str:
    return "the thesis' way" if way.startswith("thesis") else "ours"


def _percent(value: float) -> str:
    if value < 1e-6:
        return "below 1e-6 %"
    return f"{value:.3g} %" if value < 1000 else f"{value:.1e} %"


def manipulability(robot: pid.Robot, motions: Mapping[str, pid.Trajectory]) -> None:
    """The tool's manipulability along the trajectories over one period, marked where the arm is nearly singular."""
    fig, axes = figure(1, size=(9.0, 3.2))
    for (name, motion), colour in zip(motions.items(), (RESIDUAL, AS_IT_WAS, EXTENDED), strict=True):
        time, q, _, _ = motion.sample(RATE)
        poses = measure_manipulability(robot, q)
        inside, near = time * motion.base_frequency <= 1, poses.ratio < SINGULAR
        share = time * motion.base_frequency
        axes[0, 0].semilogy(share[inside], poses.measure[inside], color=colour, label=name)
        axes[0, 0].semilogy(share[inside & near], poses.measure[inside & near], ".", color=colour, markersize=5)
    axes[0, 0].set_title("dots: nearly singular", fontsize=9, loc="left")
    axes[0, 0].set_xlabel("share of a period")
    axes[0, 0].set_ylabel("sqrt det(J Jᵀ) [m³]")
    fig.legend(*axes[0, 0].get_legend_handles_labels(), ncols=3, loc="outside lower center")
    save(fig, FOLDER / "manipulability.png")
