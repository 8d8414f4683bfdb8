"""The start, end and forces of an accepted contact, where they explain the residual best."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.shape_refinement import GainEvaluator
from physident.effects.contact import PIECE, Contact

EDGES = np.arange(-5, 6) * 0.05  # s: by which a found start is moved to fit best
# s: by which both ends of a steady push are moved, coarsely, then finely
STEADY = (np.arange(-10, 11) * 0.1, np.arange(-5, 6) * 0.01)


def refine_contact(hypothesis: Hypothesis, effect: Contact) -> Contact:
    """The contact with its start and number of pieces where its forces explain most for their number (Schwarz, 1978); with
    one force for each push where that is enough."""
    after = hypothesis.with_effect(CONTACT, effect).fit  # weights by what is left beside the contact
    evaluator, ((start, end),) = GainEvaluator(hypothesis, after.weights), effect.intervals
    independent = float((len(hypothesis.data.fold) / after.memory).sum())
    pieces = max(1, round((end - start) / PIECE))
    begin = max(0.0, start)

    def value(one: Contact) -> float:
        forces = 3 * len(one.pieces())
        return evaluator.gain(hypothesis.problem.columns(one, hypothesis.model)) - forces * float(np.log(independent))

    def contact_of(first: float, count: int) -> Contact:
        return Contact(intervals=((first, first + count * PIECE),), recording=effect.recording)

    counts = range(max(1, pieces - 2), pieces + 3)
    best = max((contact_of(begin + d, k) for k in counts for d in (-PIECE, 0.0, PIECE) if begin + d >= 0), key=value)
    ((begin, end),) = best.intervals
    count = len(best.pieces())
    best = max((contact_of(begin + d, count) for d in EDGES if begin + d >= 0), key=value)
    best = _without_pauses(
        best, evaluator, hypothesis.problem.columns(best, hypothesis.model), 3 * float(np.log(independent))
    )
    steady = _with_best_ends(replace(best, steady=True), value)
    return steady if value(steady) > value(best) else best


def _with_best_ends(effect: Contact, value: Callable[[Contact], float]) -> Contact:
    """A steady contact with the ends of its intervals where they fit best, one after the other."""
    for steps in STEADY:
        for k, end in itertools.product(range(len(effect.intervals)), (0, 1)):
            every = []
            for step in steps:
                edges = np.array(effect.intervals)
                edges[k, end] = max(0.0, round(edges[k, end] + step, 3))
                if (np.diff(edges.ravel()) > 0).all():
                    every.append(replace(effect, intervals=tuple(map(tuple, edges.tolist()))))
            effect = max(every, key=value)
    return effect


def _without_pauses(effect: Contact, evaluator: GainEvaluator, columns: Columns, price: float) -> Contact:
    """The contact without the pieces, pauses between two pushes, whose force explains less than its ``price``."""
    pieces, whole = effect.pieces(), evaluator.gain(columns)
    kept = [
        piece
        for k, piece in enumerate(pieces)
        if len(pieces) == 1
        or whole - evaluator.gain(Columns.of([np.delete(c, np.s_[3 * k : 3 * k + 3], axis=1) for c in columns])) > price
    ]
    merged: list[tuple[float, float]] = []
    for start, end in kept:
        if merged and start - merged[-1][1] < 1e-6:
            merged[-1] = (merged[-1][0], end)
        else:
            merged.append((start, end))
    return Contact(intervals=tuple(merged), recording=effect.recording) if merged else effect
