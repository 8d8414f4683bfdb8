"""The arm's links in space: their collision geometry, capsules around it, and where both are in a pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.excitation.limits.capsules import Capsule, capsules_of, nearest_points
from physident.excitation.limits.state_functions import state_functions
from physident.identifiability.base_parameters import random_motion
from physident.robots.robot import Robot

Array = NDArray[np.float64]
SAMPLES = 2000  # random poses, which show the pairs of links that can touch at all
SEED = 0


@dataclass(frozen=True, eq=False)
class ArmGeometry:
    """The links of a ``model``'s robot with their collision ``geometry``, Pinocchio's geometry model.

    P points are the C capsules' ends, two each. ``values`` (..., n + 1 + 3 P) are those of ``state_functions``.
    """

    model: Model
    geometry: Any

    @property
    def robot(self) -> Robot:
        """The robot of the model."""
        return self.model.robot

    @cached_property
    def capsules(self) -> tuple[Capsule, ...]:
        """Capsules around the collision geometry."""
        return capsules_of(self.geometry)

    @cached_property
    def radii(self) -> Array:
        """Radii (C,) [m] of the capsules."""
        return np.array([capsule.radius for capsule in self.capsules])

    @cached_property
    def functions(self) -> tuple[Any, Any]:
        """CasADi functions of a state: values and their Jacobian, see ``state_functions``."""
        points = [(c.link, end) for c in self.capsules for end in (c.start, c.end)]
        return state_functions(self.model, points)

    @cached_property
    def sampled_ends(self) -> Array:
        """Ends (N, C, 2, 3) [m] of the capsules in random poses."""
        return self.ends(self.values(random_motion(self.robot, SEED, SAMPLES).q))

    def values(self, q: Array) -> Array:
        """Values (N, n + 1 + 3 P) at rest in poses (N, n)."""
        x = np.zeros((3 * q.shape[1], len(q)))
        x[: q.shape[1]] = q.T
        return np.asarray(self.functions[0].map(len(q))(x)).T

    def ends(self, values: Array) -> Array:
        """Ends (..., C, 2, 3) [m] of the capsules from values (..., n + 1 + 3 P)."""
        return values[..., self.robot.n + 1 :].reshape(*values.shape[:-1], len(self.capsules), 2, 3)

    def end_jacobians(self, jacobian: Array) -> Array:
        """Derivatives (N, C, 2, 3, 3 n) of the ends by the state, from the values' Jacobian (N, n + 1 + 3 P, 3 n)."""
        return jacobian[:, self.robot.n + 1 :].reshape(len(jacobian), len(self.capsules), 2, 3, -1)

    def tool_speed(self, q: Array, v: Array) -> Array:
        """Speed (N,) [m/s] of the tool at positions and velocities (N, n)."""
        x = np.hstack([q, v, np.zeros_like(q)]).T
        return np.sqrt(np.asarray(self.functions[0].map(len(q))(x))[self.robot.n])

    def distances(self, ends: Array, pairs: Sequence[tuple[int, int]]) -> Array:
        """Distances (..., pairs) [m] between capsules; a small overlap is a negative distance."""
        if not pairs:
            return np.zeros((*ends.shape[:-3], 0))
        first, second = (ends[..., [pair[k] for pair in pairs], :, :] for k in (0, 1))
        d, e = first[..., 1, :] - first[..., 0, :], second[..., 1, :] - second[..., 0, :]
        s, t = nearest_points(first[..., 0, :], d, second[..., 0, :], e)
        gap = first[..., 0, :] + s[..., None] * d - second[..., 0, :] - t[..., None] * e
        radii = np.array([self.capsules[i].radius + self.capsules[j].radius for i, j in pairs])
        return np.linalg.norm(gap, axis=-1) - radii


def link_name(link: int) -> str:
    """The name of a link by its number; 0 is the base."""
    return "base" if link == 0 else f"link {link}"


def index_pairs(pairs: Sequence[tuple[int, int]]) -> NDArray[np.intp]:
    """Pairs of indices as two rows (2, P)."""
    return np.array(pairs, dtype=np.intp).reshape(-1, 2).T
