"""The search: the best candidate that beats the surrogates joins, until none does; then each is tried for removal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.candidates import Candidate
from physident.diagnosis.case import Accepted, Case, State
from physident.diagnosis.contact import CONTACT, Scan, placed, scan
from physident.diagnosis.evidence import blocks
from physident.diagnosis.gains import evidence_of, gains, shares
from physident.diagnosis.intervals import resampled_reduction
from physident.diagnosis.left_out import block_costs, standard_error
from physident.diagnosis.shape import refined
from physident.diagnosis.signs import contradicted
from physident.diagnosis.surrogates import randomised
from physident.visibility import VISIBLE

Array = NDArray[np.float64]
SURROGATES = 299  # the 99th percentile is then the third largest
LEVEL = 0.99  # of a hundred clean arms one is accused of an effect, and one of a contact
LEAST_REDUCTION = 2.0  # % of one joint's RMS: below, a finding may be true and is of no use
DOUBT = 1.645  # standard errors of a paired difference: the true cause is then left out of its class once in twenty
CLOSEST = 8  # candidates that are compared block by block: a class of more is no answer
LOOPS = 3  # of forward search and removal: each loop that changes something has raised the left-out gain


@dataclass(frozen=True, eq=False)
class Look:
    """One look at all candidates beside a state: left-out evidence ``gain`` (C,), the ``least`` (C,) of it without one fold,
    ``share`` (C,) outside the baseline, the surrogates' ``threshold``, and the best ``contact`` with its own, ``touch``."""

    state: State
    gain: Array
    least: Array
    share: Array
    threshold: float
    contact: Scan
    touch: float

    def passes(self, index: int) -> bool:
        """Whether a candidate's evidence beats the surrogates' even without the fold that speaks most for it."""
        return bool(self.share[index] >= VISIBLE and self.least[index] > self.threshold)


@dataclass(frozen=True, eq=False)
class Search:
    """What was accepted and the last look, which found nothing more; ``looks`` of all steps."""

    accepted: tuple[Accepted, ...]
    last: Look
    first: Look


def look(state: State) -> Look:
    """Judge every candidate beside a state, and the best contact, each by the surrogates' luckiest of its kind."""
    evidence, baseline, now = state.evidence, state.baseline, state.fit
    responses = np.concatenate([evidence.response[:, :, None], surrogates(state)], axis=2)
    found = gains(evidence, baseline, now, responses)
    share = shares(evidence, baseline, now.weights)
    least, contact = found.least, scan(state, responses)
    # each by its own: a contact may begin anywhere, and its luckiest beginning is not to be beaten by an effect
    threshold = float(np.quantile(least[share >= VISIBLE].max(axis=0)[1:], LEVEL))
    touch = float(np.quantile(contact.evidence[1:], LEVEL))
    return Look(state, found.evidence[:, 0], least[:, 0], share, threshold, contact, touch)


def surrogates(state: State) -> Array:
    """Responses (M, n, S) without any effect: noise like the residual, and parameters as uncertain as the model's are."""
    case, now = state.case, state.fit
    noise = randomised(now.residual / now.deflation, state.evidence.regressor.segment, SURROGATES, case.seed)
    known = np.flatnonzero(case.freedom.prior > 0)
    if len(known):
        rng = np.random.default_rng([case.seed, 11])
        x = rng.standard_normal((len(known), SURROGATES)) / np.sqrt(state.baseline.prior[known])[:, None]
        for j, B in enumerate(state.baseline.joints):
            noise[:, j] += B[:, known] @ x
    return noise * state.evidence.regressor.counted[:, :, None]


def search(case: Case, progress: Callable[[str], None] = lambda _: None) -> Search:
    """Forward search with removal over a case.

    What every arm has and the model lacks, such as friction, is in from the start, until removal shows that it adds nothing:
    so much error hides what is rare, or makes it look like what is common.
    """
    accepted, first = case.lacking, None
    if accepted:
        first = look(settled(case, ()))
        progress(f"what every arm has: {', '.join(dict.fromkeys(a.candidate.name for a in accepted))}")
    last = None
    for _ in range(LOOPS):
        accepted, last, begun = _forward(case, accepted, progress)
        first = first or begun
        kept = _trimmed(case, accepted, last)
        if [a.candidate.key for a in kept] == [a.candidate.key for a in accepted]:
            break
        accepted = kept
    assert first is not None
    assert last is not None
    return Search(last.state.accepted, last, first)


def settled(case: Case, accepted: Sequence[Accepted], before: State | None = None) -> State:
    """The state beside accepted effects; columns that depend on a model are evaluated by the extended model.

    The columns of candidates stay those of a state ``before`` while the model's torque is near enough to it.
    """
    if before is None:
        before = case.state(accepted, case.model)
        return before if not accepted else case.state(accepted, before.extension.model)
    fresh = case.state(accepted, before.model, before.evidence)
    model = fresh.extension.model
    return fresh if before.near(model) else case.state(accepted, model)


def _forward(
    case: Case, accepted: tuple[Accepted, ...], progress: Callable[[str], None]
) -> tuple[tuple[Accepted, ...], Look, Look]:
    state = settled(case, accepted)
    first = None
    while True:
        now = look(state)
        first = first or now
        index = choose(now)
        if touched(now, None if index is None else float(now.gain[index])):
            chosen = Accepted(CONTACT, placed(state, now.contact.effect))
        elif index is None:
            return accepted, now, first
        else:
            candidate = state.evidence.candidates[index]
            chosen = Accepted(candidate, refined(state, candidate))
        accepted = (*accepted, chosen)
        joints = ", ".join(map(str, chosen.candidate.joints))
        progress(f"{chosen.candidate.name} on {joints or 'the arm'}")
        state = settled(case, accepted, state)


def touched(now: Look, rival: float | None) -> bool:
    """Whether the best contact passes every gate, and says more than the best other candidate."""
    found = now.contact
    useful = found.reduction >= LEAST_REDUCTION
    return bool(useful and found.evidence[0] > max(now.touch, rival or 0.0))


def choose(now: Look) -> int | None:
    """The candidate to accept: the one of the largest gain that passes every gate, or a smaller one that is as good."""
    order = [int(i) for i in np.argsort(-now.gain) if now.passes(int(i))]
    top = None
    for index in order:
        candidate = now.state.evidence.candidates[index]
        if candidate.placebo:
            return None  # where a placebo comes next, nothing after it is worth more
        if _admitted(now.state, candidate):
            top = index
            break
    if top is None:
        return None
    return _smallest(now, top, order[order.index(top) + 1 :][:CLOSEST])


def _admitted(state: State, candidate: Candidate) -> bool:
    return _useful(state, candidate) and possible_sign(state, candidate) is None


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
        if not as_good(state, other, unsurpassed, weights) or not _useful(state, other):
            continue
        if possible_sign(state, other) is None and replaces(state, other, candidates[top], now.threshold):
            best = index
    return best


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


def costs(state: State, candidate: Candidate | None, weights: Array | None = None) -> Array:
    """Squared left-out residual (G, n) of each block, with a candidate or without any, in units of the state's noise or
    of other ``weights`` (n,)."""
    labels = blocks(state.evidence, float(state.fit.memory.max()))
    options = [] if candidate is None else [state.evidence.everywhere(o.columns) for o in candidate.options]
    return block_costs(state.folded.residual(options), state.fit.weights if weights is None else weights, labels)


def reduction(before: Array, after: Array) -> float:
    """By how much [%] the RMS of the joint that feels it most falls, from squared residuals (n,) before and after."""
    left = np.maximum(after, 0.0) / np.maximum(before, 1e-300)
    return float(100 * (1 - np.sqrt(left.min())))


def _useful(state: State, candidate: Candidate) -> bool:
    """Whether what is gained on left-out rows is worth naming, and its 95 % interval over blocks lies above zero."""
    before, after = costs(state, None), costs(state, candidate)
    own = [j - 1 for j in candidate.joints] or slice(None)
    low, _ = resampled_reduction(before[:, own].sum(axis=1), after[:, own].sum(axis=1), state.case.seed)
    return low > 0 and reduction(before.sum(axis=0), after.sum(axis=0)) >= LEAST_REDUCTION


def possible_sign(state: State, candidate: Candidate) -> str | None:
    return contradicted(state.also(candidate, refined(state, candidate)))


def _trimmed(case: Case, accepted: tuple[Accepted, ...], last: Look) -> tuple[Accepted, ...]:
    """The accepted effects without those whose left-out gain beside all others no longer passes every gate."""
    kept = accepted
    for one in accepted:
        rest = tuple(a for a in kept if a is not one)
        if len(kept) < 2 or one.candidate is CONTACT:
            continue
        state = case.state(rest, last.state.model, last.state.evidence)
        if not (_least(state, one.candidate) > last.threshold and _admitted(state, one.candidate)):
            kept = rest
    return kept


def _least(state: State, candidate: Candidate) -> float:
    """A candidate's evidence without the fold that speaks most for it; none where it lies inside the baseline."""
    alone = replace(state.evidence, candidates=(candidate,))
    if shares(alone, state.baseline, state.fit.weights)[0] < VISIBLE:
        return 0.0
    return float(gains(alone, state.baseline, state.fit, alone.response[:, :, None]).least[0, 0])
