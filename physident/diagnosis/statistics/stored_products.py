"""Products of all columns over units of the recordings, from which any part of the rows can be searched without them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate, Option
from physident.diagnosis.problem.folds import blocks
from physident.diagnosis.problem.search_data import OUTSIDE
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.effects.effect import Effect

Array = NDArray[np.float64]
Key = tuple[str, tuple[int, ...]]
MAX_UNITS = 32  # more would cost memory; each is then several blocks


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
    model = problem.freedom.baseline(data.regressor).joints
    R = model[0].shape[1]
    accepted = [a for a in hypothesis.accepted if a.candidate is not CONTACT]
    refined = [problem.columns(a.effect, hypothesis.model) for a in accepted]
    candidates = [
        c
        for c in data.candidates
        if not (c.placebo or problem.is_friction_of_resting_joint(c)) and (shown is None or c.key in shown)
    ]
    wanted = sorted({column for candidate in candidates for column in _columns(candidate.options)})
    options = _options(hypothesis, accepted, candidates, {c: R + i for i, c in enumerate(wanted)}, R + len(wanted))
    size = R + len(wanted) + sum(part[0].shape[1] for part in refined) + 1
    labels = _units(blocks(data, float(hypothesis.fit.memory.max())), problem.seed)
    units = [np.flatnonzero(labels == u) for u in np.unique(labels[labels != OUTSIDE])]
    joints, places = [], []
    for j, rows in enumerate(problem.regressor.joints):
        position = {int(c): k for k, c in enumerate(rows.columns)}
        present = [i for i, c in enumerate(wanted) if c in position]
        parts = [
            (np.arange(R), model[j]),
            (R + np.array(present, dtype=np.intp), rows.values[:, [position[wanted[i]] for i in present]]),
            (np.arange(R + len(wanted), size - 1), np.column_stack([np.zeros((len(model[j]), 0)), *(c[j] for c in refined)])),
            (np.array([size - 1]), data.response[:, j : j + 1]),
        ]  # fmt: skip
        ids, columns = np.concatenate([p[0] for p in parts]), np.column_stack([p[1] for p in parts])
        used = np.flatnonzero(columns.any(axis=0))
        columns = columns[:, used]
        place = np.full(size, len(used))
        place[ids[used]] = np.arange(len(used))
        stored = np.zeros((len(units), len(used) + 1, len(used) + 1))
        for u, mine in enumerate(units):
            stored[u, :-1, :-1] = columns[mine].T @ columns[mine]
        joints.append(stored)
        places.append(place)
    counted = np.array([data.regressor.counted[mine].sum(axis=0) for mine in units])
    return StoredProducts(
        joints=tuple(joints),
        place=np.array(places),
        baseline=R,
        response=size - 1,
        options=options,
        worth=counted / hypothesis.fit.memory,
    )


def _columns(options: Sequence[Option]) -> list[int]:
    return [column for option in options for column in option.columns]


def _options(
    hypothesis: Hypothesis,
    accepted: Sequence[AcceptedEffect],
    candidates: Sequence[Candidate],
    place: dict[int, int],
    first: int,
) -> dict[Key, tuple[tuple[Effect, NDArray[np.intp]], ...]]:
    """The effect and the columns of every option; an accepted effect has one, its own, from column ``first`` on."""
    result: dict[Key, tuple[tuple[Effect, NDArray[np.intp]], ...]] = {}
    for one in accepted:
        count = len(one.effect.columns(hypothesis.problem.model.robot))
        result[one.candidate.key] = ((one.effect, np.arange(first, first + count)),)
        first += count
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
    for at, label in enumerate(np.random.default_rng([seed, 41]).permutation(every)):
        dealt[labels == label] = at % MAX_UNITS
    return dealt
