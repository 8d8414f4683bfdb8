"""Products of a baseline with its candidates and the response, from which fits, gains and costs are computed without rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.baseline_fit import NormalEquations
from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.problem.search_data import Baseline, SearchData
from physident.diagnosis.statistics.row_products import products_of

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class JointUnits:
    """Products (U, r, r) over each unit of those columns that a baseline has in one joint, their ``places`` (r - 1,) among its R,
    and the response, which is last."""

    places: NDArray[np.intp]
    products: Array


class BaselineProducts:
    """A baseline's products of some data, the ``own`` ones of the data and those of the baseline's extra columns."""

    def __init__(self, data: SearchData, baseline: Baseline) -> None:
        self.data, self.baseline = data, baseline
        self.own = products_of(data, baseline)
        self.n, self.R = len(baseline.joints), len(baseline.prior)

    @cached_property
    def BB(self) -> Array:
        """Baseline with baseline (F, n, R, R) over each fold."""
        own, result = self.own, np.zeros((len(self.own.labels), self.n, self.R, self.R))
        for j, used in enumerate(own.used):
            result[:, j, used[:, None], used] = own.folds[j][:, : len(used), : len(used)]
        for at, (first, one) in enumerate(self._extras):
            for j, cross in enumerate(own.cross(one)):
                places, used = first + one.joints[j][0], own.used[j]
                if len(places):
                    product = own.by_fold(cross[:, :, : len(used)])
                    result[:, j, places[:, None], used] = product
                    result[:, j, used[:, None], places] = product.transpose(0, 2, 1)
            for start, other in self._extras[: at + 1]:
                for j, cross in enumerate(own.between(one, other)):
                    places, others = first + one.joints[j][0], start + other.joints[j][0]
                    if len(places) and len(others):
                        product = own.by_fold(cross)
                        result[:, j, places[:, None], others] = product
                        result[:, j, others[:, None], places] = product.transpose(0, 2, 1)
        return result

    @cached_property
    def By(self) -> Array:
        """Baseline with the response (F, n, R)."""
        own, result = self.own, np.zeros((len(self.own.labels), self.n, self.R))
        for j, used in enumerate(own.used):
            result[:, j, used] = own.folds[j][:, : len(used), -1]
        for first, one in self._extras:
            for j, cross in enumerate(own.cross(one)):
                result[:, j, first + one.joints[j][0]] = own.by_fold(cross[:, :, -1])
        return result

    def BC(self, columns: NDArray[np.intp]) -> Array:
        """Baseline with some of the data's columns (F, n, R, k)."""
        own, result = self.own, np.zeros((len(self.own.labels), self.n, self.R, len(columns)))
        for j, used in enumerate(own.used):
            here = np.flatnonzero(own.place[j, columns] >= 0)
            at = own.place[j, columns[here]]
            result[:, j, used[:, None], here] = own.folds[j][:, : len(used)][:, :, at]
            for first, one in self._extras:
                places = first + one.joints[j][0]
                if len(places):
                    result[:, j, places[:, None], here] = own.by_fold(own.cross(one)[j][:, :, at])
        return result

    def Cy(self, columns: NDArray[np.intp]) -> Array:
        """Some of the data's columns with the response (F, n, k)."""
        result = np.zeros((len(self.own.labels), self.n, len(columns)))
        for j, folds in enumerate(self.own.folds):
            here = np.flatnonzero(self.own.place[j, columns] >= 0)
            result[:, j, here] = folds[:, self.own.place[j, columns[here]], -1]
        return result

    def CC(self, options: NDArray[np.intp]) -> Array:
        """The columns (O, k) of each of some options with each other (F, n, O, k, k)."""
        count, k = options.shape
        result = np.zeros((len(self.own.labels), self.n, count, k, k))
        for j, folds in enumerate(self.own.folds):
            at = self.own.place[j][options]
            here = (at >= 0)[:, :, None] & (at >= 0)[:, None, :]
            some = np.flatnonzero(here.any(axis=(1, 2)))
            at = at[some]
            result[:, j, some] = folds[:, at[:, :, None], at[:, None, :]] * here[some]
        return result

    @cached_property
    def yy(self) -> Array:
        """The response with itself (F, n)."""
        return np.stack([folds[:, -1, -1] for folds in self.own.folds], axis=1)

    @cached_property
    def equations(self) -> NormalEquations:
        """The normal equations over all rows."""
        return NormalEquations(self.BB.sum(axis=0), self.By.sum(axis=0), self.yy.sum(axis=0))

    @cached_property
    def units(self) -> list[JointUnits]:
        """What the baseline's columns and the response are over each unit, joint by joint."""
        own, result = self.own, []
        for j, used in enumerate(own.used):
            present = [(first, one) for first, one in self._extras if len(one.joints[j][0])]
            sizes = [len(one.joints[j][0]) for _, one in present]
            r, K = len(used) + sum(sizes), own.units[j].shape[2]
            ends = np.append(np.arange(len(used)), K - 1)
            product = np.zeros((len(own.fold_of_unit), r + 1, r + 1))
            mine = np.append(np.arange(len(used)), r)
            product[:, mine[:, None], mine] = own.units[j][:, :, ends]
            starts = len(used) + np.cumsum([0, *sizes])
            for k, (_, one) in enumerate(present):
                at = np.arange(starts[k], starts[k + 1])
                _fill(product, at, mine, own.cross(one)[j][:, :, ends])
                for i, (_, other) in enumerate(present[: k + 1]):
                    _fill(product, at, np.arange(starts[i], starts[i + 1]), own.between(one, other)[j])
            places = np.concatenate([used, *(first + one.joints[j][0] for first, one in present)]).astype(np.intp)
            result.append(JointUnits(places, product))
        return result

    def units_with(self, j: int, columns: Sequence[int]) -> tuple[NDArray[np.intp], Array]:
        """Which of some of the data's columns a joint has (k,), and their products (U, r, k) with what ``units`` has there."""
        own = self.own
        at = own.place[j, np.asarray(columns, dtype=np.intp)]
        here = np.flatnonzero(at >= 0)
        mine = own.units[j][:, :, at[here]]
        extra = [own.cross(one)[j][:, :, at[here]] for _, one in self._extras if len(one.joints[j][0])]
        return here, np.concatenate([mine[:, :-1], *extra, mine[:, -1:]], axis=1)

    def with_columns(self, columns: Columns) -> tuple[Array, Array, Array]:
        """Over all rows, an effect's columns with each other (n, k, k), with the baseline (n, R, k) and with the response (n, k)."""
        own, k = self.own, columns.count
        inner, cross, slope = np.zeros((self.n, k, k)), np.zeros((self.n, self.R, k)), np.zeros((self.n, k))
        for j, (places, values) in enumerate(columns.joints):
            if not len(places):
                continue
            r = self.baseline.joints[j].shape[1]
            for some in own.each_block():
                C = values[some]
                inner[j][np.ix_(places, places)] += C.T @ C
                B = self.baseline.joints[j][some]
                cross[j][np.ix_(np.arange(r), places)] += B.T @ C
                slope[j, places] += C.T @ self.data.response[some, j]
                for first, one in self._extras:
                    at, more = one.joints[j]
                    if len(at):
                        cross[j][np.ix_(first + at, places)] += more[some].T @ C
        return inner, cross, slope

    @property
    def _extras(self) -> list[tuple[int, Columns]]:
        return list(zip(self.baseline.starts, self.baseline.extra, strict=True))


@dataclass(frozen=True, eq=False)
class ResponseProducts:
    """Products over each fold of S responses with the baseline, By (F, n, R, S), with some of the data's columns, Cy (F, n, k, S), and
    with themselves, yy (F, n, S)."""

    By: Array
    Cy: Array
    yy: Array


def response_products(
    products: BaselineProducts, responses: Array, columns: NDArray[np.intp] | None = None
) -> ResponseProducts:
    """The products of responses (M, n, S) with a baseline and, where they are given, with some of the data's columns (k,)."""
    own, baseline, S = products.own, products.baseline, responses.shape[2]
    F, n, R = len(own.labels), products.n, products.R
    columns = np.zeros(0, dtype=np.intp) if columns is None else columns
    By, Cy, yy = np.zeros((F, n, R, S)), np.zeros((F, n, len(columns), S)), np.zeros((F, n, S))
    for j, used in enumerate(own.used):
        here = np.flatnonzero(own.place[j, columns] >= 0)
        at = own.place[j, columns[here]]
        total = np.zeros((F, own.folds[j].shape[1] if len(here) else len(used), S))
        for part in own.each_part():
            f, y = own.index[part.fold], responses[part.rows, j]
            rows = own.rows(j, part.rows) if len(here) else own.base_rows(j, part.rows)
            total[f] += rows.T @ y
            yy[f, j] += np.einsum("ms,ms->s", y, y)
            for first, one in zip(baseline.starts, baseline.extra, strict=True):
                places, values = one.joints[j]
                if len(places):
                    By[f, j, first + places] += values[part.rows].T @ y
        By[:, j, used] = total[:, : len(used)]
        Cy[:, j, here] = total[:, at]
    return ResponseProducts(By, Cy, yy)


def _fill(product: Array, rows: NDArray[np.intp], columns: NDArray[np.intp], values: Array) -> None:
    product[:, rows[:, None], columns] = values
    product[:, columns[:, None], rows] = values.transpose(0, 2, 1)
