"""Products of all columns over units of the recordings, from which any part of the rows can be searched without them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate, prior_precision
from physident.diagnosis.problem.folds import blocks
from physident.diagnosis.problem.search_data import OUTSIDE
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.effects.effect import Effect
from physident.large_arrays import STEP, release

Array = NDArray[np.float64]
Key = tuple[str, tuple[int, ...]]
MAX_UNITS = 32  # more would cost memory; each is then several blocks


@dataclass(frozen=True, eq=False)
class OptionClass:
    """The options of candidates that have as many columns: the candidates' ``keys``, the ``effects``, their ``columns`` (O, k) and the
    prior precision of their values ``prior`` (O, k)."""

    keys: tuple[Key, ...]
    effects: tuple[Effect, ...]
    columns: NDArray[np.intp]
    prior: Array

    def best(self, values: Array) -> list[int]:
        """The option of the largest of some values (O,) for each candidate, the first of equal ones."""
        top: dict[Key, int] = {}
        for option in np.argsort(-values, kind="stable").tolist():
            top.setdefault(self.keys[option], option)
        return list(top.values())


@dataclass(frozen=True, kw_only=True, eq=False)
class StoredProducts:
    """Products of the model's columns, all candidates' columns and the response, for each unit of blocks and each joint.

    ``joints``: one array (U, k + 1, k + 1) a joint, zero in its last row and column; ``place`` (n, columns) says where a
    column stands in a joint's array, the last place where it has no rows there. ``baseline`` counts the model's columns,
    which come first, and ``response`` is the column of the torque to explain. ``options`` has the columns of each
    candidate's options, and ``worth`` (U, n) the independent rows of each unit.
    """

    joints: tuple[Array, ...]
    place: NDArray[np.intp]
    baseline: int
    response: int
    options: dict[Key, tuple[tuple[Effect, NDArray[np.intp]], ...]]
    worth: Array

    @property
    def units(self) -> int:
        """Number of units, no two of which share a block."""
        return len(self.worth)

    @cached_property
    def classes(self) -> list[OptionClass]:
        """The options of all candidates, by their number of columns."""
        groups: dict[int, list[tuple[Key, Effect, NDArray[np.intp]]]] = {}
        for key, options in self.options.items():
            for effect, columns in options:
                groups.setdefault(len(columns), []).append((key, effect, columns))
        return [
            OptionClass(
                keys=tuple(key for key, _, _ in group),
                effects=tuple(effect for _, effect, _ in group),
                columns=np.array([columns for _, _, columns in group]),
                prior=np.array([prior_precision(effect, len(columns)) for _, effect, columns in group]),
            )
            for group in groups.values()
        ]

    def over(self, units: Sequence[int] | NDArray[np.intp]) -> Products:
        """The products over some units."""
        chosen = np.asarray(units, dtype=np.intp)
        sums = tuple(np.add.reduce(joint[chosen], axis=0) for joint in self.joints)
        return Products(sums, self.place, self.worth[chosen].sum(axis=0))


@dataclass(frozen=True, eq=False)
class Products:
    """Products over some rows: one array a joint, with the ``place`` of each column in it; ``worth`` (n,) of the rows."""

    joints: tuple[Array, ...]
    place: NDArray[np.intp]
    worth: Array

    def each(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
        """Products (n, rows, columns) of each joint."""
        return np.array(
            [G[np.ix_(p[rows], p[columns])] for G, p in zip(self.joints, self.place, strict=True)], dtype=float
        )

    def weighted(self, squares: Array, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
        """Products (rows, columns) summed over the joints with ``squares`` (n,) of their weights."""
        total = np.zeros((len(rows), len(columns)))
        for square, G, p in zip(squares, self.joints, self.place, strict=True):
            total += square * G[np.ix_(p[rows], p[columns])]
        return total

    def own(self, squares: Array, columns: NDArray[np.intp]) -> Array:
        """Products (O, k, k) of the columns (O, k) of each of some options, summed over the joints."""
        total = np.zeros((*columns.shape, columns.shape[1]))
        for square, G, p in zip(squares, self.joints, self.place, strict=True):
            at = p[columns]
            total += square * G[at[:, :, None], at[:, None, :]]
        return total


def store_products(hypothesis: Hypothesis, shown: Collection[Key] | None = None) -> StoredProducts:
    """The products of a hypothesis' rows; its accepted effects are candidates like the others, with the shape they have.

    ``shown`` are the only other candidates, by default all. Columns that depend on a model are those of the model as given: in the torque of the extended model, every torque constant
    would hold what was accepted.
    """
    data, problem = hypothesis.data, hypothesis.problem
    model, given = problem.baseline(data).joints, problem.regressor.joints
    R = model[0].shape[1]
    accepted = [a for a in hypothesis.accepted if a.candidate is not CONTACT]
    refined = [hypothesis.columns(a.candidate, a.effect) for a in accepted]
    candidates = [
        c
        for c in data.candidates
        if not (c.placebo or problem.is_friction_of_resting_joint(c)) and (shown is None or c.key in shown)
    ]
    wanted = np.array(sorted({column for c in candidates for o in c.options for column in o.columns}), dtype=np.intp)
    starts = R + len(wanted) + np.cumsum([0, *(one.count for one in refined)])
    options = _options(accepted, candidates, {int(c): R + i for i, c in enumerate(wanted)}, starts)
    size = int(starts[-1]) + 1
    labels = _units(blocks(data, float(hypothesis.fit.memory.max())), problem.seed)
    count = int(labels.max(initial=OUTSIDE)) + 1
    joints, places = [], []
    for j, rows in enumerate(given):
        taken = np.flatnonzero(np.isin(rows.columns, wanted))
        ids = [np.arange(R), R + np.searchsorted(wanted, rows.columns[taken])]
        ids += [start + one.joints[j][0] for start, one in zip(starts, refined, strict=False)]
        every = np.append(np.concatenate(ids), size - 1).astype(np.intp)
        stored = np.zeros((count, len(every) + 1, len(every) + 1))
        for some in _runs(labels):
            parts = [model[j][some], rows.some(some)[:, taken], *(one.joints[j][1][some] for one in refined)]
            T = np.column_stack([*parts, data.response[some, j]])
            stored[labels[some.start], :-1, :-1] += T.T @ T
        if len(labels) > STEP:
            release()
        used = np.append(np.flatnonzero(np.einsum("uii->i", stored[:, :-1, :-1]) > 0), len(every))
        place = np.full(size, len(used) - 1)
        place[every[used[:-1]]] = np.arange(len(used) - 1)
        joints.append(stored if len(used) == stored.shape[1] else stored[:, used[:, None], used])
        places.append(place)
    counted = np.array([data.regressor.counted[labels == u].sum(axis=0) for u in range(count)])
    return StoredProducts(
        joints=tuple(joints),
        place=np.array(places),
        baseline=R,
        response=size - 1,
        options=options,
        worth=counted.reshape(count, len(given)) / hypothesis.fit.memory,
    )


def _runs(labels: NDArray[np.intp]) -> list[slice]:
    """The rows of a unit that follow each other, at most ``STEP`` at once; gaps are left out."""
    edges = np.flatnonzero(np.diff(labels)) + 1
    return [
        slice(at, min(at + STEP, stop))
        for start, stop in zip([0, *edges.tolist()], [*edges.tolist(), len(labels)], strict=True)
        if labels[start] != OUTSIDE
        for at in range(start, stop, STEP)
    ]


def _options(
    accepted: Sequence[AcceptedEffect],
    candidates: Sequence[Candidate],
    place: dict[int, int],
    starts: NDArray[np.intp],
) -> dict[Key, tuple[tuple[Effect, NDArray[np.intp]], ...]]:
    """The effect and the columns of every option; an accepted effect has one, its own, whose columns begin at one of ``starts``."""
    result: dict[Key, tuple[tuple[Effect, NDArray[np.intp]], ...]] = {}
    for one, first, end in zip(accepted, starts, starts[1:], strict=False):
        result[one.candidate.key] = ((one.effect, np.arange(first, end)),)
    for candidate in candidates:
        result[candidate.key] = tuple(
            (option.effect, np.array([place[c] for c in option.columns]))
            for option in candidate.options
            if option.effect is not None
        )
    return result


def _units(labels: NDArray[np.intp], seed: int) -> NDArray[np.intp]:
    """Blocks dealt to at most MAX_UNITS units in an order that is drawn; OUTSIDE in gaps."""
    every = np.unique(labels[labels != OUTSIDE])
    dealt = np.full(len(labels), OUTSIDE)
    order = np.random.default_rng([seed, 41]).permutation(len(every))
    unit = np.empty(len(every), dtype=np.intp)
    unit[order] = np.arange(len(every)) % MAX_UNITS
    inside = labels != OUTSIDE
    dealt[inside] = unit[np.searchsorted(every, labels[inside])]
    return dealt
