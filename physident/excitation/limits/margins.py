"""How far a motion stays from each limit, checked afterwards and independently of the search."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from physident.excitation.limits.joint_limits import JointLimits
from physident.excitation.limits.workspace import Workspace, link_name
from physident.excitation.motion.trajectory import Trajectory
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
CHECKED = 1000  # instants of a period at least
ACTIVE = 0.02  # of a limit's size: nearer than this a limit decided the motion
NEAR_BY = 0.02  # m, the same for distances


@dataclass(frozen=True)
class Margin:
    """One limit: what it is (``limit``) and on what (``where``), what the motion ``reached`` and what is ``allowed``, in
    ``unit``, the ``margin`` between them, and whether it decided the motion (``active``)."""

    limit: str
    where: str
    reached: float
    allowed: float
    margin: float
    unit: str
    active: bool


def joint_margins(robot: Robot, trajectory: Trajectory) -> list[Margin]:
    """Margins of position, velocity and acceleration that hold at every instant."""
    limits, extent = JointLimits.of(robot), trajectory.extent()
    result = []
    for j, joint in enumerate(robot.joints):
        unit, where = "m" if joint.kind == "prismatic" else "rad", f"joint {j + 1}"
        low, high = extent.lower[j] - limits.lower[j], limits.upper[j] - extent.upper[j]
        reached, allowed = (extent.lower[j], limits.lower[j]) if low < high else (extent.upper[j], limits.upper[j])
        size = limits.upper[j] - limits.lower[j]
        result.append(_margin("position", where, reached, allowed, min(low, high), unit, ACTIVE * size))
        for name, per, reached, allowed in (
            ("speed", "/s", extent.speed[j], limits.speed[j]),
            ("acceleration", "/s^2", extent.acceleration[j], limits.acceleration[j]),
        ):
            result.append(_margin(name, where, reached, allowed, allowed - reached, unit + per, ACTIVE * allowed))
    return result


def workspace_margins(workspace: Workspace, trajectory: Trajectory) -> list[Margin]:
    """Margins of torque, tool speed, table and distances between links on at least 1,000 instants of a period.

    Torque is the whole model's, friction included; distances between links are those of the shapes themselves, by coal.
    """
    robot, result = workspace.model.robot, []
    states = period(trajectory, CHECKED)
    torque = np.abs(workspace.model.torque(states)).max(axis=0)
    for j, joint in enumerate(robot.joints):
        if np.isfinite(limit := float(robot.torque_limit[j])):
            unit = "N" if joint.kind == "prismatic" else "N m"
            result.append(_margin("torque", f"joint {j + 1}", torque[j], limit, limit - torque[j], unit, 0.05 * limit))
    if (allowed := robot.tool_speed_limit) is not None:
        speed = float(workspace.tool_speed(states.q, states.v).max())
        result.append(_margin("tool speed", "tool", speed, allowed, allowed - speed, "m/s", 0.05 * allowed))
    kept = workspace.clearance
    nearest = (("table", *lowest(workspace, states.q)), ("self-collision", *closest(workspace, states.q)))
    for name, where, distance in nearest:
        if np.isfinite(distance):
            result.append(_margin(name, where, distance, kept, distance - kept, "m", NEAR_BY))
    return result


def lowest(workspace: Workspace, q: Array) -> tuple[str, float]:
    """Which link comes nearest to the table along poses (N, n), and how near [m]; infinite without a table."""
    if not workspace.above:
        return "table", float("inf")
    height = workspace.ends(workspace.values(q))[..., 2].min(axis=0) - (workspace.table or 0.0)
    gaps = [
        (float(height[c, e]) - workspace.capsules[c].radius, workspace.capsules[c].link) for c, e in workspace.above
    ]
    gap, link = min(gaps)
    return link_name(link), gap


def closest(workspace: Workspace, q: Array) -> tuple[str, float]:
    """Which two links come nearest to each other along poses (N, n), and how near [m], by coal on the shapes."""
    import pinocchio as pin

    shapes = workspace.shapes.copy()
    shapes.removeAllCollisionPairs()
    for i, j in workspace.pairs:
        for one, other in product(workspace.capsules[i].shapes, workspace.capsules[j].shapes):
            shapes.addCollisionPair(pin.CollisionPair(one, other))
    best = ("links", float("inf"))
    if not workspace.pairs:
        return best
    model = workspace.model.robot.pinocchio
    data, found = model.createData(), pin.GeometryData(shapes)
    for pose in q:
        pin.computeDistances(model, data, shapes, found, pose)
        distances = [one.min_distance for one in found.distanceResults]
        k = int(np.argmin(distances))
        if distances[k] < best[1]:
            pair = shapes.collisionPairs[k]
            links = sorted(int(shapes.geometryObjects[g].parentJoint) for g in (pair.first, pair.second))
            best = (" and ".join(map(link_name, links)), float(distances[k]))
    return best


def period(trajectory: Trajectory, count: int) -> Signals:
    """States at ``count`` instants of a period."""
    length = 1 / trajectory.base_frequency
    states = trajectory.states(np.arange(count) / count * length)
    return replace(states, rate=count / length)


def _margin(limit: str, where: str, reached: float, allowed: float, margin: float, unit: str, near: float) -> Margin:
    return Margin(limit, where, float(reached), float(allowed), float(margin), unit, bool(margin < near))
