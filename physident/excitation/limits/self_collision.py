"""Self-collision: the distance between the arm's links."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from physident.excitation.limits.arm_geometry import ArmGeometry, index_pairs, link_name
from physident.excitation.limits.capsules import nearest_points
from physident.excitation.limits.limit import ACTIVE_DISTANCE, DISTANCE_RESERVE, LENGTH_UNIT, Margin, WorkspaceLimit
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
Pairs = tuple[tuple[int, int], ...]
NEIGHBOUR_DISTANCE = 0.02  # m: links that never get farther apart than this plus twice the clearance are neighbours


@dataclass(frozen=True)
class ExcludedPair:
    """Two links that are not kept apart: a joint connects them, or no pose brings them farther apart than a few cm.

    ``largest_distance`` [m] is the largest one over all poses, None for links that a joint connects.
    """

    first: int
    second: int
    largest_distance: float | None = None

    def __str__(self) -> str:
        apart = self.largest_distance
        reason = "joined" if apart is None else f"{apart:.3f} m apart at most, in any pose"
        return f"{link_name(self.first)} and {link_name(self.second)}: {reason}"


@dataclass(frozen=True, eq=False)
class SelfCollision(WorkspaceLimit):
    """Links that are not neighbours stay ``clearance`` [m] apart.

    The search sees capsules around the links. The margin is the distance between the collision geometry itself, by coal.
    """

    arm: ArmGeometry
    clearance: float

    lower = 0.0
    upper = np.inf

    @property
    def pairs(self) -> Pairs:
        """Pairs of capsules (two indices) that are kept apart."""
        return self._sorted_pairs[0]

    @property
    def excluded(self) -> tuple[ExcludedPair, ...]:
        """The pairs of links that are not kept apart."""
        return self._sorted_pairs[1]

    @cached_property
    def _sorted_pairs(self) -> tuple[Pairs, tuple[ExcludedPair, ...]]:
        capsules = self.arm.capsules
        parents = [-1, *(joint.parent + 1 for joint in self.arm.robot.joints)]
        separate: list[tuple[int, int]] = []
        excluded: dict[ExcludedPair, None] = {}  # several capsules of two links give one entry
        for i, j in [(first, second) for second in range(len(capsules)) for first in range(second)]:
            low, high = capsules[i].link, capsules[j].link
            if low == high:
                continue
            if parents[high] == low:
                excluded[ExcludedPair(low, high)] = None
            else:
                separate.append((i, j))
        kept = []
        distances = self.arm.distances(self.arm.sampled_ends, separate)
        for (i, j), distance in zip(separate, distances.T, strict=True):
            if distance.max() <= 2 * self.clearance + NEIGHBOUR_DISTANCE:
                largest = max(0.0, float(distance.max()))
                excluded[ExcludedPair(capsules[i].link, capsules[j].link, largest)] = None
            else:
                kept.append((i, j))
        return tuple(kept), tuple(excluded)

    @property
    def count(self) -> int:
        return len(self.pairs)

    def constraint(self, values: Array) -> Array:
        distance = self.arm.distances(self.arm.ends(values), self.pairs)
        return (distance - (self.clearance + DISTANCE_RESERVE)) / LENGTH_UNIT

    def gradient(self, values: Array, jacobian: Array) -> Array:
        ends, end_jacobians = self.arm.ends(values), self.arm.end_jacobians(jacobian)
        i, j = index_pairs(self.pairs)
        d, other = ends[:, i, 1] - ends[:, i, 0], ends[:, j, 1] - ends[:, j, 0]
        s, t = nearest_points(ends[:, i, 0], d, ends[:, j, 0], other)
        gap = ends[:, i, 0] + s[..., None] * d - ends[:, j, 0] - t[..., None] * other
        direction = gap / np.maximum(np.linalg.norm(gap, axis=-1, keepdims=True), 1e-9)
        # s and t move too, but to first order that does not change the smallest distance
        s, t = s[..., None, None], t[..., None, None]
        change = (1 - s) * end_jacobians[:, i, 0] + s * end_jacobians[:, i, 1]
        change = change - (1 - t) * end_jacobians[:, j, 0] - t * end_jacobians[:, j, 1]
        return np.einsum("npc,npcx->npx", direction, change) / LENGTH_UNIT

    def margins(self, states: Signals) -> list[Margin]:
        if not self.pairs:
            return []
        where, distance = self._closest(states.q)
        return [
            Margin.of(
                "self-collision", where, "m",
                reached=distance, allowed=self.clearance, margin=distance - self.clearance,
                active_below=ACTIVE_DISTANCE,
            )
        ]  # fmt: skip

    def _closest(self, q: Array) -> tuple[str, float]:
        """The two links that come closest to each other along poses (N, n), and their distance [m]."""
        import pinocchio as pin

        geometry = self.arm.geometry.copy()
        geometry.removeAllCollisionPairs()
        for i, j in self.pairs:
            for first, second in product(self.arm.capsules[i].geometries, self.arm.capsules[j].geometries):
                geometry.addCollisionPair(pin.CollisionPair(first, second))
        model = self.arm.robot.pinocchio
        data, geometry_data = model.createData(), pin.GeometryData(geometry)
        names, smallest = "links", float("inf")
        for pose in q:
            pin.computeDistances(model, data, geometry, geometry_data, pose)
            distances = [result.min_distance for result in geometry_data.distanceResults]
            k = int(np.argmin(distances))
            if distances[k] < smallest:
                pair, smallest = geometry.collisionPairs[k], float(distances[k])
                links = sorted(int(geometry.geometryObjects[g].parentJoint) for g in (pair.first, pair.second))
                names = " and ".join(map(link_name, links))
        return names, smallest
