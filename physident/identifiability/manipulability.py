"""How far an arm is from a singular pose: the singular values of its tool's Jacobian."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.robots.robot import Robot

Array = NDArray[np.float64]
SINGULAR = 0.01  # ratio of singular values: joints then turn a hundred times faster than in the best direction


@dataclass(frozen=True, eq=False)
class Manipulability:
    """The tool's Jacobian along N poses: ``measure`` (N,) Yoshikawa's sqrt(det(J J^T)), ``ratio`` (N,) its smallest over
    its largest singular value, with lengths in units of the arm's reach; ``lowest`` the pose (index) of the least ratio."""

    measure: Array
    ratio: Array
    lowest: int

    @property
    def near_singular(self) -> float:
        """Share of the poses, 0 to 1, that are nearly singular."""
        return float(np.mean(self.ratio < SINGULAR))

    @property
    def warning(self) -> str | None:
        """One line where some pose is nearly singular, else None."""
        if not self.near_singular:
            return None
        return (
            f"near a singularity for {100 * self.near_singular:.2g} % of the motion (singular values 1 : {SINGULAR:g}):"
            " joint motion is safe, straight lines of the tool are not"
        )

    def as_dict(self) -> dict[str, float]:
        """Its numbers for JSON."""
        return {
            "lowest": float(self.measure.min()),
            "median": float(np.median(self.measure)),
            "least_ratio": float(self.ratio.min()),
            "near_singular_share": self.near_singular,
        }

    def __repr__(self) -> str:
        return (
            f"manipulability {self.measure.min():.3g} to {self.measure.max():.3g}, median {np.median(self.measure):.3g};"
            f" singular values at worst 1 : {self.ratio.min():.2g}"
        )


def measure_manipulability(robot: Robot, q: Array) -> Manipulability:
    """Manipulability of the tool along poses q (N, n) [rad|m].

    Source: Yoshikawa, "Manipulability of robotic mechanisms" (1985), eq. 11; an arm of fewer than six joints by its own
    directions, sqrt(det(J^T J)), a tree by the joints that carry its tool. Raises InputError for poses of another number of joints.
    """
    import pinocchio as pin

    q = np.atleast_2d(np.asarray(q, dtype=float))
    if q.ndim != 2 or q.shape[1] != robot.n or not len(q):
        raise InputError(f"q has shape {q.shape}, expected (N, {robot.n})")
    model = robot.pinocchio
    data = model.createData()
    tool = pin.SE3(np.eye(3), robot.tool)
    chain = _chain(robot)
    J = np.empty((len(q), 6, len(chain)))
    for k, pose in enumerate(q):
        jacobian = pin.computeJointJacobian(model, data, pose, model.njoints - 1).reshape(6, -1)  # flat for one joint
        J[k] = tool.toActionMatrixInverse() @ jacobian[:, chain]
    size = np.linalg.svd(J, compute_uv=False)
    scaled = J.copy()
    scaled[:, :3] /= _reach(robot)
    ends = np.linalg.svd(scaled, compute_uv=False)
    ratio = ends[:, -1] / np.maximum(ends[:, 0], 1e-300)
    return Manipulability(size.prod(axis=1), ratio, int(np.argmin(ratio)))


def _chain(robot: Robot) -> list[int]:
    """The joints (from 0) from the base to the tool."""
    chain, joint = [], robot.n - 1
    while joint >= 0:
        chain.append(joint)
        joint = robot.joints[joint].parent
    return chain[::-1]


def _reach(robot: Robot) -> float:
    """The sum of the distances between joints and to the tool [m], 1 where it is zero."""
    total = sum(float(np.linalg.norm(joint.translation)) for joint in robot.joints[1:])
    return total + float(np.linalg.norm(robot.tool)) or 1.0
