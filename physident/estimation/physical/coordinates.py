"""Coordinates in which a physical fit is well scaled: every link's pseudo-inertia in units of its nominal one.

Links of an arm differ by a thousand in mass and inertia; unscaled, solvers fail on the small ones. With the nominal
P0 of a link, X = P0^-1/2 P P0^-1/2 is the identity at the nominal and its coordinates are of order one. The coordinate of
any other parameter is the torque it causes in the data, so that a stiffness in N m/rad and a friction in N m count alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Column
from physident.estimation.physical.cones import Cones, links
from physident.estimation.physical.prior import solid_link
from physident.robots.inertia import link_parameters, pseudo_inertia

Array = NDArray[np.float64]
PAIRS = [(i, j) for i in range(4) for j in range(i, 4)]
UNITS = np.zeros((10, 4, 4))  # symmetric unit matrices: X = sum_k u_k UNITS[k]
for _k, (_i, _j) in enumerate(PAIRS):
    UNITS[_k, _i, _j] = UNITS[_k, _j, _i] = 1.0
SQUARES = np.array([1.0 if i == j else 2.0 for i, j in PAIRS])  # |X|^2 = SQUARES . u^2
TRACES = np.array([1.0 if i == j else 0.0 for i, j in PAIRS])
MARGIN_ROWS = 1e-6  # by which the cones are tightened: more than a solver may violate them by
MARGIN_LINKS = 1e-6  # smallest eigenvalue of X: a link is never exactly a point, a line or a plane


@dataclass(frozen=True, eq=False)
class Coordinates:
    """theta = T u; ``nominal`` (p,) in coordinates u; ``links``: number of each link and its ten coordinates."""

    T: Array
    nominal: Array
    links: tuple[tuple[int, slice], ...]

    @staticmethod
    def around(nominal: Array, columns: Sequence[Column], sizes: Array | None = None) -> Coordinates:
        """Coordinates in units of nominal parameters (p,).

        ``sizes`` (p,) [N m|N], the torque that a unit of each parameter causes, are the units of all but the links. A link
        without mass or extent is replaced by the nearest solid one, with a PhysidentWarning that names it.
        """
        units = np.ones(len(columns)) if sizes is None else np.where(sizes > 0, sizes, 1.0)
        T, u = np.diag(1 / units), nominal * units
        found = tuple(links(columns))
        for number, link in found:
            P0 = pseudo_inertia(solid_link(nominal[link], f"link {number}"))
            values, vectors = np.linalg.eigh(P0)
            root = (vectors * np.sqrt(values)) @ vectors.T
            T[link, link] = np.column_stack([link_parameters(root @ unit @ root) for unit in UNITS])
            u[link] = TRACES
        return Coordinates(T, u, found)

    def link(self, u: Array, link: slice) -> Array:
        """X (4, 4) of one link."""
        return np.einsum("k,kij->ij", u[link], UNITS)

    def rows(self, cones: Cones) -> tuple[Array, Array]:
        """The inequality rows A, b with A u + b >= 0, each scaled to one, a margin inside the cones."""
        A = cones.rows @ self.T
        size = np.linalg.norm(A, axis=1)
        margin = np.where(cones.offsets == 0, MARGIN_ROWS, 0.0)
        return A / size[:, None], cones.offsets / size - margin

    def matrices(self, cones: Cones) -> list[tuple[Array, Array]]:
        """The matrices M, B with M u + B positive semidefinite; in units of their nominal value, a margin inside."""
        places = dict(self.links)
        result = []
        for matrix in cones.matrices:
            if matrix.link is None:
                M = matrix.map @ self.T
                W = _inverse_root(M @ self.nominal + matrix.offset)
                M, B = np.einsum("ij,jkp,kl->ilp", W, M, W, optimize=True), W @ matrix.offset @ W
                result.append((M, B - MARGIN_LINKS * np.eye(len(B))))
            else:
                M = np.zeros((4, 4, len(self.nominal)))
                M[:, :, places[matrix.link]] = np.moveaxis(UNITS, 0, 2)
                result.append((M, -MARGIN_LINKS * np.eye(4)))
        return result


def _inverse_root(P: Array) -> Array:
    """P^-1/2 (d, d) of a nominal value that is positive definite, and the identity of any other."""
    values, vectors = np.linalg.eigh(P)
    return (vectors / np.sqrt(values)) @ vectors.T if values[0] > 0 else np.eye(len(P))
