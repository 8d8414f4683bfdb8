"""Limits beyond the joints' own: torque, speed of the tool, the table, and the arm itself."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.errors import InputError
from physident.excitation.limits.capsules import Capsule, capsules_of, collision_shapes, nearest
from physident.excitation.limits.kinematics import state_functions
from physident.identifiability.base_parameters import random_motion

Array = NDArray[np.float64]
CLEARANCE = 0.02  # m: what is kept between links, and between links and the table
NEVER_FAR = (
    0.02  # m: links that come no farther apart than this and twice the clearance are neighbours across a short one
)
SAMPLES = 2000  # random poses, to see which pairs can touch at all
SEED = 0


@dataclass(frozen=True, eq=False)
class Workspace:
    """Limits of a ``model``'s robot as it stands: ``table`` [m] is the height of a plane in the base frame, None for
    none; ``clearance`` [m] is kept to it and between links. ``shapes`` are the links' collision shapes."""

    model: Model
    shapes: Any
    table: float | None = 0.0
    clearance: float = CLEARANCE

    @staticmethod
    def of(
        model: Model, table: float | None = 0.0, clearance: float = CLEARANCE, meshes: str | Path | None = None
    ) -> Workspace:
        """The workspace of a model's robot; raises InputError for shapes that cannot be read or a negative clearance."""
        if not (np.isfinite(clearance) and clearance >= 0) or not (table is None or np.isfinite(table)):
            raise InputError(
                f"clearance is {clearance} m and table {table} m, expected finite ones, clearance not negative"
            )
        return Workspace(model, collision_shapes(model.robot, meshes), table, clearance)

    @cached_property
    def capsules(self) -> tuple[Capsule, ...]:
        """Capsules around the collision shapes."""
        return capsules_of(self.shapes)

    @cached_property
    def friction(self) -> Array:
        """The largest friction and offset (n,) [N m|N] that inertia and gravity leave room for below the torque limit."""
        robot, at, total = self.model.robot, 0, np.zeros(self.model.robot.n)
        for effect in self.model.effects:
            columns = effect.columns(robot)
            theta = self.model.theta[at : at + len(columns)]
            at += len(columns)
            if effect.inertia(robot, theta) is not None:
                continue
            for k, column in enumerate(columns):
                limit = robot.velocity_limit[column.joint - 1]
                speeds = np.linspace(0, limit if np.isfinite(limit) else np.pi, 50)
                total[column.joint - 1] += np.abs(effect.friction(robot, speeds)[k] * theta[k]).max()
        return total

    @cached_property
    def functions(self) -> tuple[Any, Any]:
        """CasADi functions of a state: values and their Jacobian, see ``state_functions``."""
        points = [(c.link, end) for c in self.capsules for end in (c.start, c.end)]
        return state_functions(self.model, points)

    @cached_property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """Capsules (two indices) whose distance a motion can change and that do not always touch; see ``excluded``."""
        return self._sorted[0]

    @cached_property
    def excluded(self) -> tuple[str, ...]:
        """The pairs of links that are not kept apart, in words, and why."""
        return self._sorted[1]

    @cached_property
    def _sorted(self) -> tuple[tuple[tuple[int, int], ...], tuple[str, ...]]:
        robot = self.model.robot
        parents = [-1, *(joint.parent + 1 for joint in robot.joints)]
        every = [(i, j) for j in range(len(self.capsules)) for i in range(j)]
        apart = []
        excluded: dict[str, None] = {}
        for i, j in every:
            low, high = self.capsules[i].link, self.capsules[j].link
            if low == high:
                continue
            if parents[high] == low:
                excluded[f"{link_name(low)} and {link_name(high)}: joined"] = None
            else:
                apart.append((i, j))
        ends = self.ends(self.values(random_motion(robot, SEED, SAMPLES).q))
        distance = self.distances(ends, apart)
        kept = []
        for (i, j), d in zip(apart, distance.T, strict=True):
            if d.max() <= 2 * self.clearance + NEVER_FAR:
                names = f"{link_name(self.capsules[i].link)} and {link_name(self.capsules[j].link)}"
                excluded[f"{names}: {max(0.0, float(d.max())):.3f} m apart at most, in any pose"] = None
            else:
                kept.append((i, j))
        return tuple(kept), tuple(excluded)

    def tool_speed(self, q: Array, v: Array) -> Array:
        """Speed (N,) [m/s] of the tool at positions and velocities (N, n)."""
        x = np.hstack([q, v, np.zeros_like(q)]).T
        return np.sqrt(np.asarray(self.functions[0].map(len(q))(x))[self.model.robot.n])

    @cached_property
    def above(self) -> tuple[tuple[int, int], ...]:
        """Ends of capsules (capsule, end) that are kept above the table: those whose height a motion can change."""
        if self.table is None:
            return ()
        height = self.ends(self.values(random_motion(self.model.robot, SEED, SAMPLES).q))[..., 2]
        return tuple((c, e) for c in range(len(self.capsules)) for e in (0, 1) if np.ptp(height[:, c, e]) > 1e-6)

    def values(self, q: Array) -> Array:
        """Values (N, n + 1 + 3 P) of ``state_functions`` at rest in poses (N, n)."""
        x = np.zeros((3 * q.shape[1], len(q)))
        x[: q.shape[1]] = q.T
        return np.asarray(self.functions[0].map(len(q))(x)).T

    def ends(self, values: Array) -> Array:
        """Ends (..., C, 2, 3) of the capsules from values (..., n + 1 + 3 P)."""
        return values[..., self.model.robot.n + 1 :].reshape(*values.shape[:-1], len(self.capsules), 2, 3)

    def distances(self, ends: Array, pairs: list[tuple[int, int]] | tuple[tuple[int, int], ...]) -> Array:
        """Distances (..., pairs) [m] between capsules, negative where they overlap less than their lines."""
        if not pairs:
            return np.zeros((*ends.shape[:-3], 0))
        one, other = (ends[..., [p[k] for p in pairs], :, :] for k in (0, 1))
        d, e = one[..., 1, :] - one[..., 0, :], other[..., 1, :] - other[..., 0, :]
        s, t = nearest(one[..., 0, :], d, other[..., 0, :], e)
        gap = one[..., 0, :] + s[..., None] * d - other[..., 0, :] - t[..., None] * e
        radii = np.array([self.capsules[i].radius + self.capsules[j].radius for i, j in pairs])
        return np.linalg.norm(gap, axis=-1) - radii


def link_name(link: int) -> str:
    """A link (0 is the base) in words."""
    return "base" if link == 0 else f"link {link}"
