"""Causes at the tool or in the ground, drawn for an arm: where they are in its workspace."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from studies.open_world_second import tool_causes as tool
from studies.open_world_second.outside import Draw, Drawn
from studies.open_world_second.survey import Survey
from tests.truth import ArmTruth

Array = NDArray[np.float64]


def _stirred_fluid(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    return "velocity", tool.StirredFluid(urdf=arm.urdf, tool=arm.tool, size=0.0), 500.0


def _magnetic_drag(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    places = _places(arm, usual)
    normal = _way(rng)
    through = places[int(rng.integers(len(places)))]
    reach = float(np.std((places - through) @ normal) * rng.uniform(0.3, 0.8))
    cause = tool.MagneticDrag(
        urdf=arm.urdf, tool=arm.tool, size=0.0, through=through, normal=normal, reach=max(reach, 0.03)
    )
    return "velocity", cause, 2000.0


def _taut_cord(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    places = _places(arm, usual)
    anchor = places.mean(axis=0) + rng.uniform(0.8, 1.6) * np.ptp(places, axis=0).max() * _way(rng)
    lengths = np.linalg.norm(places - anchor, axis=1)
    slack = float(np.quantile(lengths, rng.uniform(0.2, 0.6)))
    cause = tool.TautCord(urdf=arm.urdf, tool=arm.tool, size=0.0, anchor=anchor, slack=slack, rounding=0.01)
    return "position", cause, 2000.0


def _pulsating_tool(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    frequency, phase = float(rng.uniform(0.5, 3.0)), float(rng.uniform(0, 2 * np.pi))
    cause = tool.PulsatingTool(urdf=arm.urdf, tool=arm.tool, size=0.0, way=_way(rng), frequency=frequency, phase=phase)
    return "time", cause, 500.0


def _rocking_floor(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    slow, slower = rng.uniform(4, 8), rng.uniform(8, 18)
    first, second = rng.uniform(0, 2 * np.pi, 2)
    cause = tool.RockingFloor(
        urdf=arm.urdf,
        links=arm.links,
        size=0.0,
        periods=(float(slow), float(slower)),
        phases=(float(first), float(second)),
    )
    return "time", cause, 0.12


def _way(rng: np.random.Generator) -> Array:
    """A random direction (3,)."""
    way = rng.normal(size=3)
    return way / np.linalg.norm(way)


def _places(arm: ArmTruth, usual: Survey) -> Array:
    """Where the tool goes (N, 3) [m] on the survey."""
    poses = np.concatenate([part.q[::10] for part in usual.stretches])
    return np.array([tool.tool_at(arm.urdf, arm.tool, q)[0] for q in poses])


TOOL_KINDS: dict[str, Draw] = {
    "stirred_fluid": _stirred_fluid,
    "magnetic_drag": _magnetic_drag,
    "taut_cord": _taut_cord,
    "pulsating_tool": _pulsating_tool,
    "rocking_floor": _rocking_floor,
}
