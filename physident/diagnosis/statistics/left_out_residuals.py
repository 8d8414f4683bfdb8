"""What is left of rows that were left out, block by block, for the few candidates that need more than a sum over folds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.problem.search_data import OUTSIDE, Baseline, SearchData
from physident.diagnosis.statistics.baseline_products import BaselineProducts
from physident.diagnosis.statistics.normal_equations import pseudo_inverse, whitening
from physident.large_arrays import empty

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Taken:
    """What one fold's best option takes: the ``option`` with its ``values`` (k,), and by how much (R,) the baseline's values fall."""

    option: int
    values: Array
    moved: Array


class LeftOutFits:
    """A baseline fitted outside each fold, kept, so that one candidate more costs its own products alone."""

    def __init__(
        self, data: SearchData, baseline: Baseline, weights: Array, products: BaselineProducts | None = None
    ) -> None:
        self.data, self.baseline, self.squares = data, baseline, weights**2
        self.products = BaselineProducts(data, baseline) if products is None else products
        own = self.products.own
        grams = np.tensordot(self.products.BB[own.inside], self.squares, (1, 0))
        slopes = np.tensordot(self.products.By[own.inside], self.squares, (1, 0))
        whole, slope = grams.sum(axis=0) + np.diag(baseline.prior), slopes.sum(axis=0)
        self.inverse = [pseudo_inverse(whole - part) for part in grams]
        self.x = [inverse @ (slope - part) for inverse, part in zip(self.inverse, slopes, strict=True)]

    def residual(self) -> Array:
        """Residual (M, n) [N m|N] in each fold of the baseline fitted outside it; zero in gaps."""
        own, result = self.products.own, empty(self.data.response.shape)
        place = {int(own.labels[f]): k for k, f in enumerate(own.inside)}
        for part in own.each_part():
            if part.fold == OUTSIDE:
                result[part.rows] = 0.0
                continue
            x = self.x[place[part.fold]]
            result[part.rows] = self.data.response[part.rows] - self.baseline.some_torque(part.rows, x)
        return result

    def squares_of_blocks(
        self, options: Sequence[tuple[int, ...]] | Columns = (), prior: Sequence[Array] | Array = ()
    ) -> Array:
        """Squared residual (G, n) [(N m)^2] of each block, of the baseline and the best option fitted outside its fold.

        Each option is some of the data's columns; the best has the largest gain outside the fold. ``prior`` is the prior precision of each
        option's values (k,). One option may also be given as an effect's columns, with the prior of each.
        """
        own, taken = self.products.own, self._taken(options, prior)
        result = np.zeros((len(own.blocks), self.products.n))
        for f, x, one in zip(own.inside, self.x, taken, strict=True):
            mine = np.flatnonzero(own.fold_of_unit[own.blocks] == own.labels[f])
            units = own.blocks[mine]
            moved = x if one is None else x - one.moved
            for j, joint in enumerate(self.products.units):
                c = np.append(-moved[joint.places], 1.0)
                result[mine, j] = (joint.products[units] @ c) @ c
            if one is None:
                continue
            if isinstance(options, Columns):
                cross, inner = self._units_of_effect(options), own.units_of(options)
            else:
                columns = options[one.option]
                cross = [self.products.units_with(j, columns) for j in range(self.products.n)]
                inner = own.own(tuple(columns))
            for j, ((here, product), joint) in enumerate(zip(cross, self.products.units, strict=True)):
                if len(here):
                    theta, c = one.values[here], np.append(-moved[joint.places], 1.0)
                    result[mine, j] -= 2 * np.einsum("r,urk,k->u", c, product[units], theta, optimize=True)
                    result[mine, j] += (inner[j][units][:, here[:, None], here] @ theta) @ theta
        return np.maximum(result, 0.0)

    def contradicted(
        self,
        options: Sequence[tuple[int, ...]] | Columns = (),
        prior: Sequence[Array] | Array = (),
        first: int | None = None,
    ) -> float:
        """By how much the baseline, or so many of its ``first`` values, contradict their prior beside the best option: chi squared, the mean of
        the fits outside each fold."""
        moved = [
            x if one is None else x - one.moved for x, one in zip(self.x, self._taken(options, prior), strict=True)
        ]
        return float(np.mean([self.baseline.prior[:first] @ x[:first] ** 2 for x in moved]))

    def _taken(
        self, options: Sequence[tuple[int, ...]] | Columns, prior: Sequence[Array] | Array
    ) -> Sequence[_Taken | None]:
        """The best option outside each fold."""
        if isinstance(options, Columns):
            return self._best(*self._of_effect(options), np.asarray(prior, dtype=float)[None])
        if not len(options):
            return [None] * len(self.x)
        at = np.array(options, dtype=np.intp)
        return self._best(*self._of_data(at), np.asarray(prior, dtype=float))

    def _best(self, CC: Array, BC: Array, Cy: Array, prior: Array) -> list[_Taken | None]:
        """For each fold the option of the largest gain outside it, None where nothing gains, from products (f, O, k, k), (f, R, O, k) and
        (f, O, k) over the folds and the prior precision (O, k)."""
        result: list[_Taken | None] = []
        totals, k = [part.sum(axis=0) for part in (CC, BC, Cy)], prior.shape[1]
        for f, (inverse, x) in enumerate(zip(self.inverse, self.x, strict=True)):
            inner, cross, slope = (total - part[f] for total, part in zip(totals, (CC, BC, Cy), strict=True))
            slope = slope - np.einsum("rok,r->ok", cross, x)
            Z = np.tensordot(inverse, cross, 1)
            outside = inner - np.einsum("rok,rol->okl", cross, Z) + prior[:, :, None] * np.eye(k)
            root = whitening(inner, outside)
            values = np.einsum("okl,ol->ok", root, np.einsum("okl,ok->ol", root, slope))
            seen = np.sum(slope * values, axis=1)
            top = int(np.argmax(seen))
            result.append(_Taken(top, values[top], Z[:, top] @ values[top]) if seen[top] > 0 else None)
        return result

    def _of_data(self, options: NDArray[np.intp]) -> tuple[Array, Array, Array]:
        """Weighted products over each fold of the data's columns (O, k) of some options with themselves, the baseline and the response."""
        inside, flat = self.products.own.inside, options.ravel()
        products = self.products.CC(options), self.products.BC(flat), self.products.Cy(flat)
        CC, BC, Cy = (np.tensordot(self.squares, part[inside], (0, 1)) for part in products)
        return CC, BC.reshape(*BC.shape[:2], *options.shape), Cy.reshape(len(Cy), *options.shape)

    def _of_effect(self, columns: Columns) -> tuple[Array, Array, Array]:
        """The same of an effect's columns."""
        own, k = self.products.own, columns.count
        F = len(own.labels)
        CC, BC, Cy = np.zeros((F, k, k)), np.zeros((F, self.products.R, k)), np.zeros((F, k))
        inner = own.units_of(columns)
        for j, ((here, product), joint) in enumerate(
            zip(self._units_of_effect(columns), self.products.units, strict=True)
        ):
            CC += self.squares[j] * own.by_fold(inner[j])
            if len(here):
                folds = own.by_fold(product)
                BC[:, joint.places[:, None], here] += self.squares[j] * folds[:, :-1]
                Cy[:, here] += self.squares[j] * folds[:, -1]
        return CC[own.inside][:, None], BC[own.inside][:, :, None], Cy[own.inside][:, None]

    def _units_of_effect(self, columns: Columns) -> list[tuple[NDArray[np.intp], Array]]:
        own, result = self.products.own, []
        for j, cross in enumerate(own.cross(columns)):
            r = len(own.used[j])
            extra = [own.between(columns, one)[j] for one in self.baseline.extra if len(one.joints[j][0])]
            parts = [cross[:, :, :r], *extra, cross[:, :, -1:]]
            result.append((columns.joints[j][0], np.concatenate(parts, axis=2).transpose(0, 2, 1)))
        return result


def block_costs(residual: Array, weights: Array, labels: NDArray[np.intp]) -> Array:
    """Squared weighted residual of each block (G, n), by joint."""
    squares = (residual * weights) ** 2
    inside = labels != OUTSIDE
    return np.column_stack([np.bincount(labels[inside], part[inside]).astype(float) for part in squares.T])


def standard_error(differences: Array) -> float:
    """Standard error of a sum over blocks (G,) that are independent of each other."""
    G = len(differences)
    return float(np.sqrt(G / (G - 1) * np.sum((differences - differences.mean()) ** 2)))


def reduction_percent(before: Array, after: Array) -> float:
    """By how much [%] the RMS of the joint that feels it most falls, from squared residuals (n,) before and after."""
    left = np.maximum(after, 0.0) / np.maximum(before, 1e-300)
    return float(100 * (1 - np.sqrt(left.min())))
