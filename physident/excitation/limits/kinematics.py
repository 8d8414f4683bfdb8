"""Torque, tool speed and points of a robot as CasADi functions of its state, with their Jacobians."""

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
    """CasADi functions of a state x (3 n) of q, v, a: values (n + 1 + 3 P), and their dense Jacobian by columns.

    Values are the torques of all inertia and gravity [N m|N], the square of the tool's speed [m^2/s^2], and the places (3)
    [m] of points, given by link (from 1; 0 is the base) and position in its frame. The tool is the origin of the last frame.
    """
    robot = model.robot
    x = ca.SX.sym("x", 3 * robot.n)
    q, v, a = ca.vertsplit(x, robot.n)
    links, armature = _inertia(model)
    torque = ca.mtimes(torque_expression(robot)(q, v, a), ca.DM(links)) + ca.DM(armature) * a
    frames = _frames(robot, q)
    tool = _place(frames[-1], robot.tool)
    velocity = ca.jtimes(tool, q, v)
    places = [_place(frames[link], point) for link, point in points]
    values = ca.vertcat(torque, ca.sumsqr(velocity), *places)
    jacobian = ca.densify(ca.vec(ca.jacobian(values, x)))
    return ca.Function("values", [x], [ca.densify(values)]), ca.Function("jacobian", [x], [jacobian])


def _inertia(model: Model) -> tuple[Array, Array]:
    """Link parameters (10 n,) and armature (n,) of all effects that are inertia."""
    links, armature, at = np.zeros(10 * model.robot.n), np.zeros(model.robot.n), 0
    for effect in model.effects:
        k = len(effect.columns(model.robot))
        added = effect.inertia(model.robot, model.theta[at : at + k])
        at += k
        if added is not None:
            links, armature = links + added.links, armature + added.armature
    return links, armature


def _frames(robot: Robot, q: Any) -> list[tuple[Any, Any]]:
    """Rotation (3, 3) and origin (3) of the base and of each joint's frame, in the base frame."""
    frames: list[tuple[Any, Any]] = [(ca.SX.eye(3), ca.SX(3, 1))]
    for i, joint in enumerate(robot.joints):
        R, p = frames[joint.parent + 1]
        axis, turn = ca.DM(joint.axis), ca.DM(joint.rotation)
        p = p + R @ ca.DM(joint.translation)
        R = R @ turn
        if joint.kind == "prismatic":
            p = p + R @ axis * q[i]
        else:
            K = ca.skew(axis)
            R = R @ (ca.DM.eye(3) + ca.sin(q[i]) * K + (1 - ca.cos(q[i])) * (K @ K))
        frames.append((R, p))
    return frames


def _place(frame: tuple[Any, Any], point: Array) -> Any:
    return frame[1] + frame[0] @ ca.DM(point)
