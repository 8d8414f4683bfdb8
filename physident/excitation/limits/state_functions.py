"""Torque, tool speed and points of an arm as CasADi functions of its state, with their Jacobians."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.rigid_body_regressor import torque_expression
from physident.robots.robot import Robot

Array = NDArray[np.float64]


def state_functions(model: Model, points: list[tuple[int, Array]]) -> tuple[Any, Any]:
    """CasADi functions of a state x (3 n) of q, v, a: its values (n + 1 + 3 P), and their dense Jacobian by columns.

    The values are the torques of inertia and gravity [N m|N], the square of the tool speed [m^2/s^2], and the positions (3)
    [m] of P points in the base frame. A point is given by its link (from 1; 0 is the base) and its position in the link's
    frame.
    """
    robot = model.robot
    x = ca.SX.sym("x", 3 * robot.n)
    q, v, a = ca.vertsplit(x, robot.n)
    links, armature = _inertia(model)
    torque = ca.mtimes(torque_expression(robot)(q, v, a), ca.DM(links)) + ca.DM(armature) * a
    frames = _frames(robot, q)
    tool = _position(frames[-1], robot.tool)
    velocity = ca.jtimes(tool, q, v)
    positions = [_position(frames[link], point) for link, point in points]
    values = ca.vertcat(torque, ca.sumsqr(velocity), *positions)
    jacobian = ca.densify(ca.vec(ca.jacobian(values, x)))
    return ca.Function("values", [x], [ca.densify(values)]), ca.Function("jacobian", [x], [jacobian])


def _inertia(model: Model) -> tuple[Array, Array]:
    """Sum of the link parameters (10 n,) and of the armatures (n,) of all effects that have inertia."""
    links, armature, start = np.zeros(10 * model.robot.n), np.zeros(model.robot.n), 0
    for effect in model.effects:
        k = len(effect.columns(model.robot))
        added = effect.inertia(model.robot, model.theta[start : start + k])
        start += k
        if added is not None:
            links, armature = links + added.links, armature + added.armature
    return links, armature


def _frames(robot: Robot, q: Any) -> list[tuple[Any, Any]]:
    """Rotation (3, 3) and origin (3) of the base and of each joint's frame, in the base frame."""
    frames: list[tuple[Any, Any]] = [(ca.SX.eye(3), ca.SX(3, 1))]
    for i, joint in enumerate(robot.joints):
        R, p = frames[joint.parent + 1]
        axis = ca.DM(joint.axis)
        p = p + R @ ca.DM(joint.translation)
        R = R @ ca.DM(joint.rotation)
        if joint.kind == "prismatic":
            p = p + R @ axis * q[i]
        else:
            K = ca.skew(axis)
            R = R @ (ca.DM.eye(3) + ca.sin(q[i]) * K + (1 - ca.cos(q[i])) * (K @ K))
        frames.append((R, p))
    return frames


def _position(frame: tuple[Any, Any], point: Array) -> Any:
    return frame[1] + frame[0] @ ca.DM(point)
