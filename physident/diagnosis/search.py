"""The search: the best candidate that beats the surrogates joins, until none does; then each is tried for removal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.candidates import Candidate
from physident.diagnosis.case import Accepted, Case, State
from physident.diagnosis.evidence import blocks, gains, shares
from physident.diagnosis.left_out import block_costs, left_out_residual, standard_error
from physident.diagnosis.shape import refined
from physident.diagnosis.signs import contradicted
from physident.diagnosis.surrogates import randomised
from physident.visibility import VISIBLE

Array = NDArray[np.float64]
SURROGATES = 199  # the 98th percentile is then the fourth largest
LEVEL = 0.98  # one clean arm in fifty is accused of something
LEAST_REDUCTION = 2.0  # % of RMS: below, a finding may be true and is of no use
DOUBT = 2.0  # standard errors of a paired difference that two causes must differ by to be told apart
CLOSEST = 8  # candidates that are compared block by block: a class of more is no answer
LOOPS = 3  # of forward search and removal: each loop that changes something has raised the left-out gain


@dataclass(frozen=True, eq=False)
class Look:
    """One look at all candidates beside a state: left-out ``gain`` (C,), that of the best fold ``luckiest`` (C,),
    ``share`` (C,) outside the baseline, and the surrogates' ``threshold``."""

    state: State
    gain: Array
    luckiest: Array
    share: Array
    threshold: float

    def passes(self, index: int) -> bool:
        """Whether a candidate's gain beats the surrogates', and does not come from one fold alone."""
        gain = self.gain[index]
        stable = gain - self.luckiest[index] > 0
        return bool(self.share[index] >= VISIBLE and gain > self.threshold and stable)


@dataclass(frozen=True, eq=False)
class Search:
    """What was accepted and the last look, which found nothing more; ``looks`` of all steps."""

    accepted: tuple[Accepted, ...]
    last: Look
    first: Look


def look(state: State, threshold: float | None = None) -> Look:
    """Judge every candidate beside a state; the threshold is drawn anew unless given."""
    evidence, baseline, now = state.evidence, state.baseline, state.fit
    responses = evidence.response[:, :, None]
    if threshold is None:
        responses = np.concatenate([responses, surrogates(state)], axis=2)
    found = gains(evidence, baseline, now.weights, responses)
    share = shares(evidence, baseline, now.weights)
    total = found.sum(axis=1)
    if threshold is None:
        threshold = float(np.quantile(total[share >= VISIBLE][:, 1:].max(axis=0), LEVEL))
    return Look(state, total[:, 0], found[:, :, 0].max(axis=1), share, threshold)


def surrogates(state: State) -> Array:
    """Responses (M, n, S) without any effect: noise like the residual, and parameters as uncertain as the model's are."""
    case, now = state.case, state.fit
    noise = randomised(now.residual / now.deflation, state.evidence.regressor.segment, SURROGATES, case.seed)
    known = np.flatnonzero(state.baseline.prior > 0)
    if len(known):
        rng = np.random.default_rng([case.seed, 11])
        x = rng.standard_normal((len(known), SURROGATES)) / np.sqrt(state.baseline.prior[known])[:, None]
        for j, B in enumerate(state.baseline.joints):
            noise[:, j] += B[:, known] @ x
    return noise * state.evidence.regressor.counted[:, :, None]


def search(case: Case, progress: Callable[[str], None] = lambda _: None) -> Search:
    """Forward search with removal over a case."""
    accepted: tuple[Accepted, ...] = ()
    first = last = None
    for _ in range(LOOPS):
        accepted, last, begun = _forward(case, accepted, progress)
        first = first or begun
        kept = _trimmed(case, accepted, last)
        if [a.candidate.key for a in kept] == [a.candidate.key for a in accepted]:
            break
        accepted = kept
    assert first is not None and last is not None
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


def _forward(case: Case, accepted: tuple[Accepted, ...], progress: Callable[[str], None]) -> tuple[tuple[Accepted, ...], Look, Look]:
    state = settled(case, accepted)
    first = None
    while True:
        now = look(state)
        first = first or now
        index = choose(now)
        if index is None:
            return accepted, now, first
        candidate = state.evidence.candidates[index]
        accepted = (*accepted, Accepted(candidate, refined(state, candidate)))
        progress(f"{candidate.name} on {', '.join(map(str, candidate.joints)) or 'the arm'}")
        state = settled(case, accepted, state)


def choose(now: Look) -> int | None:
    """The candidate to accept: the one of the largest gain that passes every gate, or a smaller one that is as good."""
    order = [int(i) for i in np.argsort(-now.gain) if now.passes(int(i))]
    top = None
    for index in order:
        candidate = now.state.evidence.candidates[index]
        if candidate.placebo:
            return None  # where a placebo comes next, nothing after it is worth more
        if _useful(now.state, candidate) and possible_sign(now.state, candidate) is None:
            top = index
            break
    if top is None:
        return None
    return _smallest(now, top, order[order.index(top) + 1 :][:CLOSEST])


def _smallest(now: Look, top: int, others: Sequence[int]) -> int:
    """The candidate with the fewest numbers to choose among those whose gain the data cannot tell from the top's."""
    state = now.state
    candidates = state.evidence.candidates
    best = top
    lead = costs(state, candidates[top])
    for index in others:
        smaller = candidates[index].size < candidates[best].size
        if not smaller or candidates[index].placebo:
            continue
        loss = costs(state, candidates[index]) - lead
        as_good = loss.sum() < DOUBT * standard_error(loss.sum(axis=1))
        if not as_good or not _useful(state, candidates[index]) or possible_sign(state, candidates[index]):
            continue
        beside = state.also(candidates[index], refined(state, candidates[index]))
        earned = costs(beside, None).sum() - costs(beside, candidates[top]).sum()
        if earned < now.threshold:  # else both are at work, and the larger gain comes first
            best = index
    return best


def costs(state: State, candidate: Candidate | None) -> Array:
    """Squared weighted left-out residual (G, n) of each block, with a candidate or without any."""
    labels = blocks(state.evidence, float(state.fit.memory.max()))
    return block_costs(_residual(state, candidate), state.fit.weights, labels)


def _residual(state: State, candidate: Candidate | None) -> Array:
    options = [] if candidate is None else [state.evidence.everywhere(o.columns) for o in candidate.options]
    return left_out_residual(state.evidence, state.baseline, state.fit.weights, options)


def reduction(before: Array, after: Array, joints: Sequence[int]) -> float:
    """By how much [%] the RMS over some joints (from 1; all where empty) falls, from squared weighted residuals (..., n)."""
    own = [j - 1 for j in joints] or slice(None)
    return 100 * (1 - float(np.sqrt(after[..., own].sum() / max(before[..., own].sum(), 1e-300))))


def _useful(state: State, candidate: Candidate) -> bool:
    return reduction(costs(state, None), costs(state, candidate), candidate.joints) >= LEAST_REDUCTION


def possible_sign(state: State, candidate: Candidate) -> str | None:
    return contradicted(state.also(candidate, refined(state, candidate)))


def _trimmed(case: Case, accepted: tuple[Accepted, ...], last: Look) -> tuple[Accepted, ...]:
    """The accepted effects without those whose left-out gain beside all others no longer beats the threshold."""
    kept = accepted
    for one in accepted:
        rest = tuple(a for a in kept if a is not one)
        if len(kept) < 2:
            break
        now = look(case.state(rest, last.state.model, last.state.evidence), last.threshold)
        index = [c.key for c in now.state.evidence.candidates].index(one.candidate.key)
        if not now.passes(index):
            kept = rest
    return kept
