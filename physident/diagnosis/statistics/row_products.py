"""Products of a search's columns over parts of the rows, gathered in blocks of rows: all that a linear fit needs of them.

A recording may have millions of rows. They are read once for each set of columns; every fit, gain and cost is then computed from
products, which are as large for a day as for a minute.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.problem.folds import blocks
from physident.diagnosis.problem.search_data import OUTSIDE, Baseline, SearchData
from physident.large_arrays import BLOCK, STEP, release, steps

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Part:
    """Consecutive rows of one unit and one fold."""

    rows: slice
    unit: int
    fold: int


class DataProducts:
    """Products of the columns of some search data and of a model's ``base`` (M, r) in each joint's rows.

    A joint has the columns ``own``: its base columns that are not zero, its candidates' columns, and the response, which is last.
    ``folds`` (F, K, K) are their products in each joint over each fold, whose labels are ``labels``, and ``units`` (U, r + 1, K)
    those of the base columns and the response with all columns over each unit, a block of rows or all rows between blocks.
    """

    def __init__(self, data: SearchData, base: tuple[Array, ...]) -> None:
        # what the data keep is these products: with it they would hold each other, and their memory until the next collection
        self.data, self.base, self.token = replace(data, kept={}), base, object()
        self.labels, self.fold = np.unique(data.fold), data.fold
        self.parts, self.fold_of_unit = _parts(data)
        # of the unit between blocks it says nothing
        self.recording_of_unit = np.zeros(len(self.fold_of_unit), dtype=np.intp)
        for part in self.parts:
            self.recording_of_unit[part.unit] = data.regressor.recording[part.rows.start]
        self.index = {int(label): k for k, label in enumerate(self.labels)}
        self.inside = np.flatnonzero(self.labels != OUTSIDE)
        self.blocks = np.flatnonzero(self.fold_of_unit != OUTSIDE)
        self.used = [np.flatnonzero(_nonzero(B)) for B in base]
        self.first = [int(np.searchsorted(rows.columns, data.model_columns)) for rows in data.regressor.joints]
        self.columns = [rows.columns[k:] for rows, k in zip(data.regressor.joints, self.first, strict=True)]
        self.place = np.full((len(base), len(data.regressor.columns)), -1)
        for j, columns in enumerate(self.columns):
            self.place[j, columns] = len(self.used[j]) + np.arange(len(columns))
        self._own: dict[tuple[int, ...], Array] = {}
        self._gather()

    def _gather(self) -> None:
        U = len(self.fold_of_unit)
        self.folds, self.units = [], []
        for j, (used, columns) in enumerate(zip(self.used, self.columns, strict=True)):
            r, K = len(used), len(used) + len(columns) + 1
            folds, units = np.zeros((len(self.labels), K, K)), np.zeros((U, r + 1, K))
            ends = np.append(np.arange(r), K - 1)
            for part in self.each_part():
                T = self.rows(j, part.rows)
                product = T.T @ T
                folds[self.index[part.fold]] += product
                units[part.unit] += product[ends]
            self.folds.append(folds)
            self.units.append(units)

    def each_part(self) -> Iterator[Part]:
        """All parts of the rows; the memory of large arrays is given back once in a block and at the end."""
        seen = 0
        for part in self.parts:
            yield part
            seen += part.rows.stop - part.rows.start
            if seen > BLOCK:
                seen = 0
                release()
        if len(self.fold) > STEP:
            release()

    def each_block(self) -> Iterator[slice]:
        """All rows, some at a time."""
        return steps(len(self.fold))

    def rows(self, j: int, rows: slice) -> Array:
        """Some rows (m, K) of a joint."""
        joint = self.data.regressor.joints[j]
        values = joint.plain[rows, self.first[j] :]
        if joint.weight is not None:
            values = values * joint.weight[rows, None]
        return np.column_stack([self.base_rows(j, rows), values, self.data.response[rows, j]])

    def base_rows(self, j: int, rows: slice) -> Array:
        """Some rows (m, r) of a joint's base columns."""
        base = self.base[j][rows]
        return base if len(self.used[j]) == base.shape[1] else base[:, self.used[j]]

    def own(self, columns: tuple[int, ...]) -> Array:
        """Products (n, U, k, k) of some of the data's columns over each unit."""
        if columns not in self._own:
            self._own[columns] = self.units_of(self.data.columns(columns))
        return self._own[columns]

    def units_of(self, columns: Columns) -> Array:
        """Products (n, U, k, k) of an effect's columns over each unit."""
        result = np.zeros((len(self.base), len(self.fold_of_unit), columns.count, columns.count))
        for j, (places, values) in enumerate(columns.joints):
            if len(places):
                for part in self.parts:
                    some = values[part.rows]
                    result[j, part.unit][np.ix_(places, places)] += some.T @ some
        return result

    def cross(self, columns: Columns) -> list[Array]:
        """Products (U, c, K) of an effect's columns in each joint with the joint's own columns."""
        key = (self.token,)
        if key not in columns.products:
            result = [
                np.zeros((len(self.fold_of_unit), len(p), self.units[j].shape[2]))
                for j, (p, _) in enumerate(columns.joints)
            ]
            for j, (places, values) in enumerate(columns.joints):
                if len(places):
                    for part in self.each_part():
                        result[j][part.unit] += values[part.rows].T @ self.rows(j, part.rows)
            columns.products[key] = result
        return columns.products[key]

    def between(self, one: Columns, other: Columns) -> list[Array]:
        """Products (U, c, d) of two effects' columns in each joint."""
        key = (self.token, other.token)
        if key not in one.products:
            result = []
            for (a, left), (b, right) in zip(one.joints, other.joints, strict=True):
                product = np.zeros((len(self.fold_of_unit), len(a), len(b)))
                if len(a) and len(b):
                    for part in self.parts:
                        product[part.unit] += left[part.rows].T @ right[part.rows]
                result.append(product)
            one.products[key] = result
        return one.products[key]

    def by_fold(self, units: Array) -> Array:
        """Sums (F, ...) over the units (U, ...) of each fold."""
        return np.tensordot(self._belongs, units, (1, 0))

    @cached_property
    def _belongs(self) -> Array:
        return (self.labels[:, None] == self.fold_of_unit).astype(float)


def products_of(data: SearchData, baseline: Baseline) -> DataProducts:
    """The products of some data beside a baseline, computed once for the same rows, folds and base columns."""
    known: list[DataProducts] = data.kept.setdefault("products", [])
    for one in known:
        if one.base is baseline.joints and (one.fold is data.fold or np.array_equal(one.fold, data.fold)):
            return one
    known.append(DataProducts(data, baseline.joints))
    del known[:-2]  # with and without the rows of a contact
    return known[-1]


def _parts(data: SearchData) -> tuple[list[Part], NDArray[np.intp]]:
    """Parts of consecutive rows, and the fold (U,) of each unit: the blocks, and what lies between them."""
    labels = blocks(data, float(data.memory.max()))
    count = int(labels.max(initial=OUTSIDE)) + 1
    edges = np.flatnonzero((labels[1:] != labels[:-1]) | (data.fold[1:] != data.fold[:-1])) + 1
    fold_of_unit, parts = np.full(count + bool((labels == OUTSIDE).any()), OUTSIDE), []
    for start, stop in zip(np.append(0, edges), np.append(edges, len(labels)), strict=True):
        label, fold = int(labels[start]), int(data.fold[start])
        unit = count if label == OUTSIDE else label
        fold_of_unit[unit] = fold
        parts += [Part(slice(at, min(at + STEP, int(stop))), unit, fold) for at in range(int(start), int(stop), STEP)]
    return parts, fold_of_unit


def _nonzero(values: Array) -> NDArray[np.bool_]:
    found = np.zeros(values.shape[1], dtype=bool)
    for at in range(0, len(values), STEP):
        found |= values[at : at + STEP].any(axis=0)
    return found
