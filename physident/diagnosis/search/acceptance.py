"""The gates that a candidate must pass to be named, and which of several that pass is taken."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.problem.evidence import blocks
from physident.diagnosis.search.candidate_scores import Look
from physident.diagnosis.search.hypothesis import State
from physident.diagnosis.search.physical_signs import contradicted
from physident.diagnosis.search.shape_refinement import refined
from physident.diagnosis.statistics.intervals import resampled_reduction
from physident.diagnosis.statistics.left_out_gains import evidence_of
from physident.diagnosis.statistics.left_out_residuals import block_costs, reduced, standard_error

Array = NDArray[np.float64]
LEAST_REDUCTION = 2.0  # % of one joint's RMS: below, a finding may be true and is of no use
DOUBT = 1.645  # standard errors of a paired difference: the true cause is then left out of its class once in twenty
CLOSEST = 8  # candidates that are compared block by block: a class of more is no answer


def choose(now: Look) -> int | None:
    """The candidate to accept: the one of the largest gain that passes every gate, or a smaller one that is as good."""
    order = [int(i) for i in np.argsort(-now.gain) if now.passes(int(i))]
    top = None
    for index in order:
        candidate = now.state.evidence.candidates[index]
        if candidate.placebo:
            return None  # where a placebo comes next, nothing after it is worth more
        if admitted(now.state, candidate):
            top = index
            break
    if top is None:
        return None
    return _smallest(now, top, order[order.index(top) + 1 :][:CLOSEST])


def touched(now: Look, rival: float | None) -> bool:
    """Whether the best contact passes every gate, even without the joint that speaks most for it, and says more than the best
    other candidate."""
    found = now.contact
    useful = min(found.reduction, found.felt) >= LEAST_REDUCTION
    return bool(useful and found.evidence[0] > max(now.touch, rival or 0.0) and found.least[0] > now.touch_least)


def _smallest(now: Look, top: int, others: Sequence[int]) -> int:
    """The candidate with the fewest numbers to choose among those whose gain the data cannot tell from the top's."""
    state = now.state
    candidates = state.evidence.candidates
    best, weights, unsurpassed = top, None, np.zeros(0)
    for index in others:
        other = candidates[index]
        if other.size >= candidates[best].size or other.placebo:
            continue
        if weights is None:
            weights = state.also(candidates[top], refined(state, candidates[top])).fit.weights
            unsurpassed = costs(state, candidates[top], weights)
        if not as_good(state, other, unsurpassed, weights) or not useful(state, other):
            continue
        if possible_sign(state, other) is None and replaces(state, other, candidates[top], now.threshold):
            best = index
    return best


def admitted(state: State, candidate: Candidate) -> bool:
    """Whether what a candidate gains is of use, and the arm it makes is possible."""
    return useful(state, candidate) and possible_sign(state, candidate) is None


def useful(state: State, candidate: Candidate) -> bool:
    """Whether what is gained on left-out rows is worth naming, and its 95 % interval over blocks lies above zero."""
    before, after = costs(state, None), costs(state, candidate)
    own = [j - 1 for j in candidate.joints] or slice(None)
    low, _ = resampled_reduction(before[:, own].sum(axis=1), after[:, own].sum(axis=1), state.case.seed)
    return low > 0 and reduced(before.sum(axis=0), after.sum(axis=0)) >= LEAST_REDUCTION


def possible_sign(state: State, candidate: Candidate) -> str | None:
    """What a candidate makes impossible, in words; None where the extended arm can exist."""
    return contradicted(state.also(candidate, refined(state, candidate)))


def costs(state: State, candidate: Candidate | None, weights: Array | None = None) -> Array:
    """Squared left-out residual (G, n) of each block, with a candidate or without any, in units of the state's noise or
    of other ``weights`` (n,)."""
    labels = blocks(state.evidence, float(state.fit.memory.max()))
    options = [] if candidate is None else [state.evidence.everywhere(o.columns) for o in candidate.options]
    return block_costs(state.folded.residual(options), state.fit.weights if weights is None else weights, labels)


def as_good(state: State, other: Candidate, cost: Array, weights: Array) -> bool:
    """Whether another candidate loses less on left-out rows than the scatter over blocks of the ``cost`` (G, n) of one in its
    place can tell."""
    loss = (costs(state, other, weights) - cost).sum(axis=1)
    return bool(loss.sum() < DOUBT * standard_error(loss))


def replaces(state: State, other: Candidate, one: Candidate, threshold: float) -> bool:
    """Whether beside another candidate the first has nothing left to add: else both are at work, or it is the better."""
    beside = state.also(other, refined(state, other))
    before, after = costs(beside, None).sum(axis=0), costs(beside, one).sum(axis=0)
    worth = beside.evidence.regressor.counted[beside.inside].sum(axis=0) / beside.fit.memory
    return float(evidence_of(before[:, None], (before - after)[:, None], worth)[0]) < threshold
