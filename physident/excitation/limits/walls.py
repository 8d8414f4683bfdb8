"""The workspace's limits as constraints on a motion, with their gradients, and as one number for many motions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.excitation.limits.capsules import nearest
from physident.excitation.limits.workspace import Workspace
from physident.excitation.motion.series import Series
from physident.excitation.search.nlp import Rows

Array = NDArray[np.float64]
NODES = 48  # of a period
HELD_BACK = 0.03  # of torque and tool speed, for what happens between the nodes
HELD_APART = 0.01  # m, for the same reason
LENGTH = 0.3  # m: distances are judged in this unit, as torques are in that of their limit
TOUCHED = 1e-12  # of a row's unit: a smaller derivative is rounding
SEED = 0


@dataclass(frozen=True, eq=False)
class Walls:
    """The limits of a ``workspace`` on motions of a ``series``.

    A row for each joint with a torque limit, one for the square of the tool's speed, one for each end of a capsule above
    the table, one for each pair of capsules; all in units of their limit.
    """

    workspace: Workspace
    series: Series

    def rows(self) -> Rows:
        """The limits as constraints on instants of a period."""
        n, m = self.series.n, self.series.m
        bases = self.series.basis(np.arange(NODES) / NODES)
        values, jacobian = (function.map(NODES) for function in self.workspace.functions)

        def state(y: Array) -> Array:
            rows = y.reshape(n, m)
            return np.concatenate([rows @ basis.T for basis in bases])

        def gradient(y: Array) -> Array:
            x = state(y)
            V = np.asarray(values(x)).T
            J = np.asarray(jacobian(x)).T.reshape(NODES, 3 * n, -1)  # CasADi stacks columns
            D = self._slopes(V, np.swapaxes(J, 1, 2)).reshape(NODES, -1, 3, n)
            parts = [D[:, :, k, :, None] * basis[:, None, None, :] for k, basis in enumerate(bases)]
            return parts[0] + parts[1] + parts[2]

        rng = np.random.default_rng(SEED)
        moved = [np.abs(gradient(y)) > TOUCHED for y in rng.standard_normal((3, n * m))]
        touched = np.any(moved, axis=(0, 1, 4))  # (R, n)
        pattern = np.broadcast_to(touched[None, :, :, None], (NODES, *touched.shape, m))
        at = np.nonzero(pattern.reshape(NODES * len(touched), n * m))
        kind = np.arange(len(touched))
        lower, upper = np.where(kind < len(self._loaded), -1.0, 0.0), np.where(kind < self._capped, 1.0, np.inf)
        return Rows(
            np.tile(lower, NODES), np.tile(upper, NODES), np.column_stack(at).astype(np.intp),
            lambda y: self._measured(np.asarray(values(state(y))).T).ravel(), lambda y: gradient(y)[pattern],
        )  # fmt: skip

    def violation(self) -> Callable[[Array], Array]:
        """A function of motions (P, n m): the sum of the worst excesses (P, 1) of some instants, zero where all hold."""
        nodes = NODES // 2
        bases = self.series.basis(np.arange(nodes) / nodes)

        def worst(y: Array) -> Array:
            rows = y.reshape(len(y), self.series.n, self.series.m)
            x = np.concatenate([rows @ basis.T for basis in bases], axis=1)  # (P, 3 n, K)
            values = self.workspace.functions[0].map(len(y) * nodes)
            g = self._measured(np.asarray(values(np.hstack(list(x)))).T)
            beyond = np.concatenate([np.abs(g[:, : self._capped]) - 1, -g[:, self._capped :]], axis=1)
            return np.maximum(beyond.reshape(len(y), nodes, -1).max(axis=1), 0.0).sum(axis=1, keepdims=True)

        return worst

    @cached_property
    def _loaded(self) -> NDArray[np.intp]:
        """Joints (from 0) with a torque limit."""
        return np.flatnonzero(np.isfinite(self.workspace.model.robot.torque_limit))

    @cached_property
    def _room(self) -> Array:
        """Torque left for inertia and gravity on those joints; none where friction takes it all, which no motion meets."""
        limit, friction = self.workspace.model.robot.torque_limit[self._loaded], self.workspace.friction[self._loaded]
        return np.maximum((1 - HELD_BACK) * limit - friction, 1e-6 * limit)

    @property
    def _capped(self) -> int:
        """Rows that are bounded by one: torques, then the speed of the tool where it has a limit."""
        return len(self._loaded) + (self.workspace.model.robot.tool_speed_limit is not None)

    def _fast(self, V: Array) -> list[Array]:
        """The speed of the tool in values or their Jacobian, where it has a limit."""
        n, limit = self.series.n, self.workspace.model.robot.tool_speed_limit
        return [] if limit is None else [V[:, n : n + 1] / ((1 - HELD_BACK) * limit) ** 2]

    def _measured(self, V: Array) -> Array:
        """Rows (N, R) from values (N, n + 1 + 3 P) of the workspace's functions."""
        space = self.workspace
        ends, kept = space.ends(V), space.clearance + HELD_APART
        c, e = _places(space.above)
        radii = np.array([capsule.radius for capsule in space.capsules])
        height = ends[:, c, e, 2] - radii[c] - (space.table or 0.0)
        distance = space.distances(ends, space.pairs)
        parts = [V[:, self._loaded] / self._room, *self._fast(V), (height - kept) / LENGTH, (distance - kept) / LENGTH]
        return np.concatenate(parts, axis=1)

    def _slopes(self, V: Array, J: Array) -> Array:
        """Derivatives (N, R, 3 n) of ``_measured`` by the state, from values and their Jacobian (N, n + 1 + 3 P, 3 n)."""
        space = self.workspace
        ends = space.ends(V)
        E = J[:, self.series.n + 1 :].reshape(len(J), len(space.capsules), 2, 3, -1)
        c, e = _places(space.above)
        i, j = _places(space.pairs)
        d, other = ends[:, i, 1] - ends[:, i, 0], ends[:, j, 1] - ends[:, j, 0]
        s, t = nearest(ends[:, i, 0], d, ends[:, j, 0], other)
        gap = ends[:, i, 0] + s[..., None] * d - ends[:, j, 0] - t[..., None] * other
        way = gap / np.maximum(np.linalg.norm(gap, axis=-1, keepdims=True), 1e-9)
        # the nearest points move along their lines too, but that changes the distance by nothing to first order
        s, t = s[..., None, None], t[..., None, None]
        moved = (1 - s) * E[:, i, 0] + s * E[:, i, 1] - (1 - t) * E[:, j, 0] - t * E[:, j, 1]
        apart = np.einsum("npc,npcx->npx", way, moved)
        parts = [J[:, self._loaded] / self._room[:, None], *self._fast(J), E[:, c, e, 2] / LENGTH, apart / LENGTH]
        return np.concatenate(parts, axis=1)


def _places(pairs: tuple[tuple[int, int], ...]) -> NDArray[np.intp]:
    """Two rows (2, P) of indices."""
    return np.array(pairs, dtype=np.intp).reshape(-1, 2).T
