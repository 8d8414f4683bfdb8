"""Where the joints of a robot are in a user's MuJoCo model, and how its body frames lie in the robot's joint frames."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.export.mujoco import mujoco_module
from physident.graphics.scene import link_poses
from physident.robots.robot import Robot

Array = NDArray[np.float64]
SAMPLES = 8  # positions of the arm at which both kinematics are compared
CLOSE = 1e-4  # rad, and m for each metre of the arm: beyond the rounding of a description, below any real difference

EARLIER = 100.0  # times the weight of the next joint, where the pose of the base is found


@dataclass(frozen=True, eq=False)
class Match:
    """A robot of n joints in a MuJoCo model.

    ``base`` (3, 3) rotates from the robot's base frame to the world; ``frames`` (n, 4, 4) place each joint's body in the
    joint's frame of the robot. ``positions``, ``velocities`` (n,) index the joints in MuJoCo's vectors.
    """

    base: Array
    frames: Array
    positions: NDArray[np.intp]
    velocities: NDArray[np.intp]


def match(robot: Robot, model: Any, source: str) -> Match:
    """Find a robot's joints by name in a compiled MuJoCo model, whose kinematics must be the robot's up to the choice of
    body frames and of the base; raises InputError, naming ``source`` and the joint, where they are not."""
    mujoco = mujoco_module()

    joints = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name) for name in robot.joint_names]
    if missing := [name for name, j in zip(robot.joint_names, joints, strict=True) if j < 0]:
        raise InputError(
            f"{source}: has no joint named {', '.join(map(repr, missing))}; expected the model's joint names"
        )
    kinds = {"revolute": mujoco.mjtJoint.mjJNT_HINGE, "prismatic": mujoco.mjtJoint.mjJNT_SLIDE}
    for number, (joint, j) in enumerate(zip(robot.joints, joints, strict=True), 1):
        if model.jnt_type[j] != kinds[joint.kind]:
            raise InputError(f"{source}: joint {number} ({joint.name}) is not {joint.kind}, as it is in the model")
        if model.body_jntnum[model.jnt_bodyid[j]] != 1:
            raise InputError(
                f"{source}: the body of joint {number} ({joint.name}) has several joints; expected one a body"
            )
    q = np.random.default_rng(0).uniform(-1.0, 1.0, size=(SAMPLES, robot.n))
    theirs, axes, anchors = _poses(model, joints, q)
    rotations, positions = link_poses(robot, q)
    ours = np.zeros((robot.n, SAMPLES, 4, 4))
    ours[..., :3, :3], ours[..., :3, 3], ours[..., 3, 3] = rotations, positions, 1.0
    directions = np.einsum("jsab,jb->jsa", rotations, np.array([joint.axis for joint in robot.joints]))
    base = _base(directions, positions, axes, anchors)
    relative = np.linalg.inv(base @ ours) @ theirs
    _compare(robot, relative, axes - directions @ base[:3, :3].T, source)
    return Match(
        base[:3, :3],
        relative[:, 0],
        np.array([model.jnt_qposadr[j] for j in joints], dtype=np.intp),
        np.array([model.jnt_dofadr[j] for j in joints], dtype=np.intp),
    )


def _poses(model: Any, joints: list[int], q: Array) -> tuple[Array, Array, Array]:
    """Poses (n, S, 4, 4) of the joints' bodies, and axes and anchors (n, S, 3) of the joints, in the world."""
    mujoco = mujoco_module()

    data: Any = mujoco.MjData(model)
    poses = np.zeros((len(joints), len(q), 4, 4))
    axes, anchors = np.zeros((2, len(joints), len(q), 3))
    for s, position in enumerate(q):
        for j, value in zip(joints, position, strict=True):
            data.qpos[model.jnt_qposadr[j]] = value
        mujoco.mj_kinematics(model, data)
        for k, j in enumerate(joints):
            body = model.jnt_bodyid[j]
            poses[k, s, :3, :3], poses[k, s, :3, 3] = data.xmat[body].reshape(3, 3), data.xpos[body]
            poses[k, s, 3, 3] = 1.0
            axes[k, s], anchors[k, s] = data.xaxis[j], data.xanchor[j]
    return poses, axes, anchors


def _base(directions: Array, positions: Array, axes: Array, anchors: Array) -> Array:
    """The pose (4, 4) of the robot's base in the world under which the axes of the joints fall together best."""
    from scipy.spatial.transform import Rotation

    ours, theirs = directions.reshape(-1, 3), axes.reshape(-1, 3)
    # joints near the base count more, so that the first joint that differs is the one that does not fit
    weights = np.repeat(EARLIER ** -np.arange(len(axes), dtype=float), axes.shape[1])
    base = np.eye(4)
    if not np.allclose(ours, theirs, atol=CLOSE):
        base[:3, :3] = Rotation.align_vectors(theirs, ours, weights)[0].as_matrix()
    across = np.eye(3) - theirs[:, :, None] * theirs[:, None, :]  # an anchor may lie anywhere on its axis
    gap = anchors.reshape(-1, 3) - positions.reshape(-1, 3) @ base[:3, :3].T
    across = weights[:, None, None] * across
    right = np.einsum("sab,sb->sa", across, gap).ravel()
    base[:3, 3] = np.linalg.lstsq(across.reshape(-1, 3), right, rcond=1e-12)[0]
    return base


def _compare(robot: Robot, relative: Array, turned: Array, source: str) -> None:
    """Raises InputError for the first joint whose body does not move as the robot's link does."""
    reach = max(1.0, float(np.abs([joint.translation for joint in robot.joints]).sum()))
    spread = np.abs(relative - relative[:, :1])
    angles = np.maximum(np.abs(turned).max(axis=(1, 2)), spread[..., :3, :3].max(axis=(1, 2, 3)))
    distances = spread[..., :3, 3].max(axis=(1, 2))
    errors = np.maximum(angles, distances / reach)
    if errors.max() > CLOSE:
        j = int(np.argmax(errors > errors.max() / EARLIER**0.5))
        raise InputError(
            f"{source}: joint {j + 1} ({robot.joint_names[j]}) moves otherwise than in the model, by up to {1e3 * distances[j]:.3g} mm and {angles[j]:.3g} rad; expected the same axes, zeros and lengths"
        )
