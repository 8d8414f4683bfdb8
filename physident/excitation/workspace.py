"""Limits beyond the joints' own: torque, speed of the tool, the table, and the arm itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.base_parameters import random_motion
from physident.errors import InputError
from physident.excitation.capsules import Capsule, capsules_of, collision_shapes, nearest
from physident.excitation.kinematics import state_functions
from physident.excitation.nlp import Rows
from physident.excitation.series import Series
from physident.model import Model

Array = NDArray[np.float64]
CLEARANCE = 0.02  # m: what is kept between links, and between links and the table
NODES = 48  # of a period
HELD_BACK = 0.03  # of torque and tool speed, for what happens between the nodes
HELD_APART = 0.01  # m, for the same reason
LENGTH = 0.3  # m: distances are judged in this unit, as torques are in that of their limit
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
            if effect.name == "torque_offset" or effect.inertia(robot, theta) is not None:
                continue
            for k, column in enumerate(columns):
                limit = robot.velocity_limit[column.joint - 1]
                speeds = np.linspace(0, limit if np.isfinite(limit) else np.pi, 50)
                total[column.joint - 1] += np.abs(effect.friction(robot, speeds)[k] * theta[k]).max()
        return total

    @cached_property
    def _functions(self) -> tuple[Any, Any]:
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
                excluded[f"{_name(low)} and {_name(high)}: joined"] = None
            else:
                apart.append((i, j))
        ends = self._ends(self._values(random_motion(robot, SEED, SAMPLES).q))
        distance = self._distances(ends, apart)
        kept = []
        for (i, j), d in zip(apart, distance.T, strict=True):
            if d.max() <= 2 * (self.clearance + HELD_APART):
                names = f"{_name(self.capsules[i].link)} and {_name(self.capsules[j].link)}"
                excluded[f"{names}: {max(0.0, float(d.max())):.3f} m apart at most, in any pose"] = None
            else:
                kept.append((i, j))
        return tuple(kept), tuple(excluded)

    def rows(self, series: Series) -> Rows:
        """The limits as constraints on instants of a period."""
        n, m, nodes = series.n, series.m, NODES
        bases = series.basis(np.arange(nodes) / nodes)
        values, jacobian = (function.map(nodes) for function in self._functions)

        def state(y: Array) -> Array:
            rows = y.reshape(n, m)
            return np.concatenate([rows @ basis.T for basis in bases])

        def gradient(y: Array) -> Array:
            x = state(y)
            V = np.asarray(values(x)).T
            J = np.asarray(jacobian(x)).T.reshape(nodes, 3 * n, -1)  # CasADi stacks columns
            D = self._slopes(V, np.swapaxes(J, 1, 2)).reshape(nodes, -1, 3, n)
            return sum(D[:, :, k, :, None] * basis[:, None, None, :] for k, basis in enumerate(bases))  # pyright: ignore[reportReturnType]

        rng = np.random.default_rng(SEED)
        touched = np.any([gradient(y) != 0 for y in rng.standard_normal((3, n * m))], axis=(0, 1, 4))  # (R, n)
        pattern = np.broadcast_to(touched[None, :, :, None], (nodes, *touched.shape, m))
        count = nodes * len(touched)
        at = np.nonzero(pattern.reshape(count, n * m))
        lower = np.where(np.arange(len(touched)) < self._bounded, -1.0, 0.0)
        upper = np.where(np.arange(len(touched)) < self._capped, 1.0, np.inf)
        return Rows(
            np.tile(lower, nodes), np.tile(upper, nodes), np.column_stack(at).astype(np.intp),
            lambda y: self._measured(np.asarray(values(state(y))).T).ravel(), lambda y: gradient(y)[pattern],
        )  # fmt: skip

    def violation(self, series: Series) -> Callable[[Array], Array]:
        """A function of motions (P, n m): the worst excess (P, 1) over a few instants, negative where all hold."""
        nodes = NODES // 2
        bases = series.basis(np.arange(nodes) / nodes)

        def worst(y: Array) -> Array:
            rows = y.reshape(len(y), series.n, series.m)
            x = np.concatenate([rows @ basis.T for basis in bases], axis=1)  # (P, 3 n, K)
            g = self._measured(np.asarray(self._functions[0].map(len(y) * nodes)(np.hstack(list(x)))).T)
            beyond = np.concatenate([np.abs(g[:, : self._capped]) - 1, -g[:, self._capped :]], axis=1)
            worst_each = beyond.reshape(len(y), nodes, -1).max(axis=1)
            return np.maximum(worst_each, 0.0).sum(axis=1, keepdims=True)

        return worst

    def tool_speed(self, q: Array, v: Array) -> Array:
        """Speed (N,) [m/s] of the tool at positions and velocities (N, n)."""
        x = np.hstack([q, v, np.zeros_like(q)]).T
        return np.sqrt(np.asarray(self._functions[0].map(len(q))(x))[self.model.robot.n])

    def lowest(self, q: Array) -> tuple[str, float]:
        """Which link comes nearest to the table along poses (N, n), and how near [m]; infinite without a table."""
        if not self.above:
            return "table", float("inf")
        height = self._ends(self._values(q))[..., 2].min(axis=0) - (self.table or 0.0)
        gaps = [(float(height[c, e]) - self.capsules[c].radius, self.capsules[c].link) for c, e in self.above]
        gap, link = min(gaps)
        return _name(link), gap

    def closest(self, q: Array) -> tuple[str, float]:
        """Which two links come nearest to each other along poses (N, n), and how near [m], by coal on the shapes."""
        import pinocchio as pin

        links = {(self.capsules[i].link, self.capsules[j].link) for i, j in self.pairs}
        shapes = self.shapes.copy()
        shapes.removeAllCollisionPairs()
        objects = list(enumerate(shapes.geometryObjects))
        for i, one in objects:
            for j, other in objects[:i]:
                if tuple(sorted((int(one.parentJoint), int(other.parentJoint)))) in links:
                    shapes.addCollisionPair(pin.CollisionPair(j, i))
        if not len(shapes.collisionPairs):
            return "links", float("inf")
        model = self.model.robot.pinocchio
        data, found = model.createData(), pin.GeometryData(shapes)
        best = ("links", float("inf"))
        for pose in q:
            pin.computeDistances(model, data, shapes, found, pose)
            distances = [one.min_distance for one in found.distanceResults]
            k = int(np.argmin(distances))
            if distances[k] < best[1]:
                pair = shapes.collisionPairs[k]
                ends = [_name(int(shapes.geometryObjects[g].parentJoint)) for g in (pair.first, pair.second)]
                best = (" and ".join(sorted(ends)), float(distances[k]))
        return best

    @cached_property
    def _loaded(self) -> NDArray[np.intp]:
        """Joints (from 0) with a torque limit."""
        return np.flatnonzero(np.isfinite(self.model.robot.torque_limit))

    @cached_property
    def _room(self) -> Array:
        """Torque left for inertia and gravity on those joints."""
        return (1 - HELD_BACK) * self.model.robot.torque_limit[self._loaded] - self.friction[self._loaded]

    @property
    def _bounded(self) -> int:
        return len(self._loaded)

    @property
    def _capped(self) -> int:
        """Rows that are bounded by one: torques, then the speed of the tool where it has a limit."""
        return len(self._loaded) + (self.model.robot.tool_speed_limit is not None)

    @cached_property
    def above(self) -> tuple[tuple[int, int], ...]:
        """Ends of capsules (capsule, end) that are kept above the table: those whose height a motion can change."""
        if self.table is None:
            return ()
        height = self._ends(self._values(random_motion(self.model.robot, SEED, SAMPLES).q))[..., 2]
        return tuple((c, e) for c in range(len(self.capsules)) for e in (0, 1) if np.ptp(height[:, c, e]) > 1e-6)

    def _measured(self, V: Array) -> Array:
        """Rows (N, R) in units of their limits from values (N, n + 1 + 3 P): torques, tool speed squared, heights, distances."""
        n, ends = self.model.robot.n, self._ends(V)
        parts = [V[:, self._loaded] / self._room]
        if (limit := self.model.robot.tool_speed_limit) is not None:
            parts.append(V[:, n : n + 1] / ((1 - HELD_BACK) * limit) ** 2)
        kept = self.clearance + HELD_APART
        c, e = (np.array([one[k] for one in self.above], dtype=np.intp) for k in (0, 1))
        radii = np.array([capsule.radius for capsule in self.capsules])
        parts.append((ends[:, c, e, 2] - radii[c] - (self.table or 0.0) - kept) / LENGTH)
        parts.append((self._distances(ends, self.pairs) - kept) / LENGTH)
        return np.concatenate(parts, axis=1)

    def _slopes(self, V: Array, J: Array) -> Array:
        """Derivatives (N, R, 3 n) of ``_measured`` by the state, from values and their Jacobian (N, n + 1 + 3 P, 3 n)."""
        n, ends = self.model.robot.n, self._ends(V)
        E = J[:, n + 1 :].reshape(len(J), len(self.capsules), 2, 3, -1)
        parts = [J[:, self._loaded] / self._room[:, None]]
        if (limit := self.model.robot.tool_speed_limit) is not None:
            parts.append(J[:, n : n + 1] / ((1 - HELD_BACK) * limit) ** 2)
        c, e = (np.array([one[k] for one in self.above], dtype=np.intp) for k in (0, 1))
        parts.append(E[:, c, e, 2] / LENGTH)
        i, j = (np.array([pair[k] for pair in self.pairs], dtype=np.intp) for k in (0, 1))
        d, other = ends[:, i, 1] - ends[:, i, 0], ends[:, j, 1] - ends[:, j, 0]
        s, t = nearest(ends[:, i, 0], d, ends[:, j, 0], other)
        gap = ends[:, i, 0] + s[..., None] * d - ends[:, j, 0] - t[..., None] * other
        way = gap / np.maximum(np.linalg.norm(gap, axis=-1, keepdims=True), 1e-9)
        # the nearest points move along their lines too, but that changes the distance by nothing to first order
        s, t = s[..., None, None], t[..., None, None]
        moved = (1 - s) * E[:, i, 0] + s * E[:, i, 1] - (1 - t) * E[:, j, 0] - t * E[:, j, 1]
        parts.append(np.einsum("npc,npcx->npx", way, moved) / LENGTH)
        return np.concatenate(parts, axis=1)

    def _values(self, q: Array) -> Array:
        """Values (N, n + 1 + 3 P) of ``state_functions`` at rest in poses (N, n)."""
        x = np.zeros((3 * q.shape[1], len(q)))
        x[: q.shape[1]] = q.T
        return np.asarray(self._functions[0].map(len(q))(x)).T

    def _ends(self, values: Array) -> Array:
        """Ends (..., C, 2, 3) of the capsules from values (..., n + 1 + 3 P)."""
        return values[..., self.model.robot.n + 1 :].reshape(*values.shape[:-1], len(self.capsules), 2, 3)

    def _distances(self, ends: Array, pairs: list[tuple[int, int]] | tuple[tuple[int, int], ...]) -> Array:
        """Distances (..., pairs) [m] between capsules, negative where they overlap less than their lines."""
        if not pairs:
            return np.zeros((*ends.shape[:-3], 0))
        one, other = (ends[..., [p[k] for p in pairs], :, :] for k in (0, 1))
        d, e = one[..., 1, :] - one[..., 0, :], other[..., 1, :] - other[..., 0, :]
        s, t = nearest(one[..., 0, :], d, other[..., 0, :], e)
        gap = one[..., 0, :] + s[..., None] * d - other[..., 0, :] - t[..., None] * e
        radii = np.array([self.capsules[i].radius + self.capsules[j].radius for i, j in pairs])
        return np.linalg.norm(gap, axis=-1) - radii


def _name(link: int) -> str:
    return "base" if link == 0 else f"link {link}"
