"""A session: the recordings that together let a diagnosis split, compare speeds, and know a mass."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from physident.dynamics.model import Model
from physident.effects.payload import Payload
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.excitation.design import Design, Limits, check_counts, design_trajectory
from physident.excitation.limits.margins import joint_margins, workspace_margins
from physident.excitation.limits.workspace import CLEARANCE, Workspace
from physident.excitation.motion.trajectory import Trajectory
from physident.robots.robot import Robot

SHORTEST = 15.0  # s of a recording: blocks of ten correlation lengths, and the filter's ends


@dataclass(frozen=True, eq=False)
class Leg:
    """One recording of a session: its ``name``, the motion, its share of the designed ``speed``, whether the arm is
    ``loaded``, and whether it is a ``holdout`` that nothing is fitted to."""

    name: str
    trajectory: Trajectory
    speed: float
    loaded: bool
    holdout: bool


@dataclass(frozen=True, eq=False)
class Session:
    """The ``legs`` of a session in the order to record them, and the ``designs`` behind them."""

    legs: tuple[Leg, ...]
    designs: tuple[Design, ...]

    @property
    def duration(self) -> float:
        """Time in motion of all legs [s]."""
        return sum(leg.trajectory.duration for leg in self.legs)

    def save(self, folder: str | Path) -> list[Path]:
        """Write each leg as NAME.json into a folder that exists; returns the paths."""
        paths = [Path(folder) / f"{leg.name}.json" for leg in self.legs]
        for leg, path in zip(self.legs, paths, strict=True):
            leg.trajectory.save(path)
        return paths

    def __repr__(self) -> str:
        rows = [
            f"Session: {len(self.legs)} recordings, {self.duration:.0f} s in motion",
            "  name                       speed     load   duration [s]   for",
        ]
        rows += [
            f"  {leg.name:<24} {100 * leg.speed:5.0f} %   {'yes' if leg.loaded else 'no':>6} {leg.trajectory.duration:14.1f}"
            f"   {'holdout' if leg.holdout else 'fit'}"
            for leg in self.legs
        ]
        fitted = sum(not leg.holdout for leg in self.legs)
        return "\n".join(
            [
                *rows,
                f"verdict: {fitted} recordings to fit, which are left out by turns, {len(self.legs) - fitted} held out",
            ]
        )


def design_session(
    source: Robot | Model | Estimate,
    load: float | None = None,
    motions: int = 2,
    speeds: tuple[float, ...] = (1.0, 0.5),
    seed: int = 0,
    limits: Limits = "all",
    base_frequency: float = 0.15,
    table: float | None = 0.0,
    clearance: float = CLEARANCE,
    meshes: str | Path | None = None,
    progress: Callable[[float], None] = lambda _: None,
    **settings: Any,
) -> Session:
    """Several designed motions at two speeds, without and with a ``load`` [kg] at the tool, and one held out.

    Diagnosis leaves recordings out by turns from four on, two ``speeds`` (shares of the designed one) separate friction's
    laws, and a known load fixes the torques' scale. Every leg lasts 15 s at least. The load is a point at the tool, and the loaded
    legs keep the torque limit with it. ``settings`` go to ``design_trajectory``. Raises InputError for a load or speeds
    that cannot be, fewer than two motions, or a loaded leg beyond the torque limit.
    """
    check_counts(motions=motions)
    if motions < 2 or len(speeds) < 2 or not all(0 < s <= 1 for s in speeds) or len(set(speeds)) < len(speeds):
        raise InputError(
            f"motions {motions}, speeds {speeds}: expected two or more motions at two or more speeds from 0 to 1"
        )
    if load is not None and not (math.isfinite(load) and load > 0):
        raise InputError(f"load is {load} kg, expected a positive mass, or none")
    count = motions + 1
    designs = tuple(
        design_trajectory(
            source, limits=limits, base_frequency=base_frequency, seed=seed + k, table=table, clearance=clearance, meshes=meshes,
            progress=lambda share, k=k: progress((k + share) / count), **settings,
        )
        for k in range(count)
    )  # fmt: skip
    legs = []
    for loaded in (False,) if load is None else (False, True):
        for speed in speeds:
            for k, one in enumerate(designs[:-1]):
                legs.append(_leg(f"motion{k + 1}", one.trajectory, speed, loaded, False))
    legs.append(_leg("holdout", designs[-1].trajectory, speeds[0], False, True))
    if load is not None and limits == "all":
        _check_loaded(source, load, legs, table, clearance, meshes)
    return Session(tuple(legs), designs)


def slowed(trajectory: Trajectory, speed: float) -> Trajectory:
    """The same path at a share of the speed, over as many periods."""
    return replace(trajectory, base_frequency=trajectory.base_frequency * speed, duration=trajectory.duration / speed)


def _leg(stem: str, trajectory: Trajectory, speed: float, loaded: bool, holdout: bool) -> Leg:
    slow = slowed(trajectory, speed)
    period = 1 / slow.base_frequency
    whole = replace(slow, duration=max(1, math.ceil(SHORTEST / period - 1e-9)) * period)
    name = f"{stem}_{round(100 * speed)}percent{'_loaded' if loaded else ''}"
    return Leg(stem if holdout else name, whole, speed, loaded, holdout)


def _check_loaded(
    source: Robot | Model | Estimate, load: float, legs: list[Leg], table: float | None, clearance: float, meshes: Any
) -> None:
    """Raises InputError where a loaded leg exceeds a limit."""
    arm = (
        source.model if isinstance(source, Estimate) else Model.nominal(source) if isinstance(source, Robot) else source
    )
    robot = arm.robot
    x, y, z = robot.tool
    body = load * np.array([1, x, y, z, y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y])
    heavy = Model(robot, (*arm.effects, Payload()), np.concatenate([arm.theta, body]))
    workspace = Workspace.of(heavy, table, clearance, meshes)
    for leg in legs:
        margins = (
            [*joint_margins(robot, leg.trajectory), *workspace_margins(workspace, leg.trajectory)] if leg.loaded else []
        )
        for one in margins:
            if not one.margin > 0:
                raise InputError(
                    f"{leg.name}: with {load:g} kg the {one.limit} of {one.where} reaches {one.reached:.4g} {one.unit}, allowed is {one.allowed:.4g}; expected a lighter load"
                )
