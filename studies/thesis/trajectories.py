"""The thesis' trajectories beside ours: condition, limits, boundary conditions, what the tool does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

import physident as pid
from physident.dynamics.rigid_body_regressor import torque_regressor
from physident.effects.catalogue import make_effects
from physident.identifiability.base_parameters import find_base_parameters
from physident.identifiability.manipulability import measure_manipulability
from studies.thesis.halves import HALVES, half
from studies.thesis.published import RATE

Array = NDArray[np.float64]


def condition(robot: pid.Robot, motion: pid.Trajectory, joints: slice = slice(None)) -> float:
    """cond(Y_B) over the motion at 125 Hz, Y_B the first independent columns in Pinocchio's order, unscaled."""
    _, q, v, a = motion.sample(RATE)
    base = find_base_parameters(robot, make_effects(["rigid_body"]))
    Y = torque_regressor(robot, *(np.ascontiguousarray(x[:, joints]) for x in (q, v, a)))[:, :, base.independent]
    return float(np.linalg.cond(Y.reshape(-1, base.r)))


def conditions(robot: pid.Robot, motion: pid.Trajectory) -> dict[str, float]:
    """cond(Y_B) of the halves and of the whole arm."""
    halves = {name: condition(half(name), motion, joints) for name, joints in HALVES.items()}
    return halves | {"whole": condition(robot, motion)}


def properties(robot: pid.Robot, motion: pid.Trajectory) -> dict[str, Any]:
    """Condition numbers, the share of each limit used, velocity and acceleration at the start, and the tool's extremes."""
    extent, start = motion.extent(), motion.states(np.zeros(1))
    heights, speeds = tool(robot, motion)
    poses = measure_manipulability(robot, motion.sample(RATE)[1])
    return {
        "cond": conditions(robot, motion),
        "q_used": float(np.max(np.maximum(-extent.lower / -robot.lower, extent.upper / robot.upper))),
        "v_used": float(np.max(extent.speed / robot.velocity_limit)),
        "a_used": float(np.max(extent.acceleration / np.array(robot.acceleration_limit))),
        "v_start": float(np.abs(start.v).max()),
        "a_start": float(np.abs(start.a).max()),
        "tool_speed": float(speeds.max()),
        "lowest_joint": float(heights.min()),
        "manipulability": poses.as_dict() | {"warning": poses.warning},
    }


def tool(robot: pid.Robot, motion: pid.Trajectory) -> tuple[Array, Array]:
    """Along a motion at 125 Hz: height (N,) [m] of the lowest of joints 3-6 and the tool, and tool speed (N,) [m/s]."""
    model = robot.pinocchio
    data, frame = model.createData(), model.getFrameId("tool0")
    _, q, v, _ = motion.sample(RATE)
    heights, speeds = np.empty((2, len(q)))
    for k in range(len(q)):
        J = pin.computeFrameJacobian(model, data, q[k], frame, pin.LOCAL_WORLD_ALIGNED)
        pin.updateFramePlacements(model, data)
        heights[k] = min(data.oMf[frame].translation[2], *(data.oMi[i].translation[2] for i in range(3, 7)))
        speeds[k] = np.linalg.norm(J[:3] @ v[k])
    return heights, speeds
