"""How well each candidate does on left-out rows, beside what it reaches by chance on surrogates of the residual."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.search.contact_scan import ContactScan, scan_contacts
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.left_out_gains import Judge, LeftOutGains, left_out_gains
from physident.diagnosis.statistics.stored_products import Key
from physident.diagnosis.statistics.surrogates import phase_randomised
from physident.diagnosis.statistics.thresholds import SURROGATES, contact_threshold, effect_threshold
from physident.effects.catalogue import effect_scope
from physident.identifiability.visibility import VISIBLE
from physident.large_arrays import blocks, steps
from physident.processes import mapped

Array = NDArray[np.float64]
R = TypeVar("R")
AT_ONCE = 1 << 25  # bytes of surrogates that are judged together
EVEN = 4  # parts at least, and a multiple of it: two or four processes then end together
FEWEST = 24  # surrogates, or little less where parts are even: the rows are read once for each such group


@dataclass(frozen=True, kw_only=True, eq=False)
class CandidateScores:
    """Scores of all candidates beside a hypothesis.

    ``gain`` (C,): evidence on left-out rows; ``evidence_without_best_fold`` (C,): the same without the fold that supports it
    most; ``visible_share`` (C,) of a candidate's columns outside the baseline; ``chance``: the evidence without the
    best fold (S,) that each reached on surrogates, by its name and joints; ``threshold``: what the best candidate
    reaches by chance. ``contact`` is the best contact, with thresholds of its own for its evidence and for its evidence
    without its strongest joint, infinite where no surrogate was searched for contacts, because this one is of no use.
    """

    hypothesis: Hypothesis
    gain: Array
    evidence_without_best_fold: Array
    visible_share: Array
    chance: dict[Key, Array]
    threshold: float
    contact: ContactScan
    contact_threshold: float
    contact_threshold_without_best_joint: float

    @property
    def contact_may_come_first(self) -> bool:
        """Whether the best contact is of use and exceeds its threshold, or one that is yet to be drawn."""
        unknown = math.isinf(self.contact_threshold)
        return self.contact.is_of_use and (unknown or bool(self.contact.evidence[0] > self.contact_threshold))

    def beats_chance(self, index: int) -> bool:
        """Whether a candidate can be seen at all and beats its threshold even without its best fold."""
        if self.visible_share[index] < VISIBLE:
            return False
        key = self.hypothesis.data.candidates[index].key
        return bool(self.evidence_without_best_fold[index] > self.threshold_of(key, self.hypothesis.accepted))

    def threshold_of(self, key: Key, accepted: Sequence[AcceptedEffect]) -> float:
        """What an effect, by its name and joints, must exceed beside others: what the best of all candidates reaches by chance.

        Where most joints have the effect, what is found there has chosen the other joints, and only these few can be lucky.
        """
        name, _ = key
        same = {one for one in self.chance if one[0] == name}
        others = same - {one.candidate.key for one in accepted} | {key}
        if not effect_scope(name).joins_joints or len(same) <= 2 * len(others) or key not in same:
            return self.threshold
        few = np.array([self.chance[one] for one in sorted(others)])
        return min(self.threshold, effect_threshold(few, np.ones(len(few))))


def rescore_candidates(hypothesis: Hypothesis, before: CandidateScores) -> CandidateScores:
    """Score every candidate beside a hypothesis against the thresholds of earlier scores, without new surrogates."""
    data, baseline, fit = hypothesis.data, hypothesis.baseline, hypothesis.fit
    scores = left_out_gains(data, baseline, fit, products=hypothesis.products)
    return replace(
        before,
        hypothesis=hypothesis,
        gain=scores.evidence[:, 0],
        evidence_without_best_fold=scores.evidence_without_best_fold[:, 0],
        visible_share=_visible(hypothesis, scores),
        contact=scan_contacts(hypothesis, data.response[:, :, None], hypothesis.products.By[..., None]),
    )


def score_candidates(hypothesis: Hypothesis) -> CandidateScores:
    """Score every candidate beside a hypothesis, and surrogates of its residual in the same way."""
    data, products = hypothesis.data, hypothesis.products
    judge = Judge(data, hypothesis.baseline, hypothesis.fit, products)
    own = judge.gains()
    visible = _visible(hypothesis, own)
    contact = scan_contacts(hypothesis, data.response[:, :, None], products.By[..., None])

    def scored(responses: Array) -> Array:
        return judge.gains(judge.products_with(responses)).evidence_without_best_fold

    chance = np.concatenate(over_surrogates(hypothesis, scored), axis=1)
    least, least_without = contact_thresholds(hypothesis) if contact.is_of_use else (np.inf, np.inf)
    return CandidateScores(
        hypothesis=hypothesis,
        gain=own.evidence[:, 0],
        evidence_without_best_fold=own.evidence_without_best_fold[:, 0],
        visible_share=visible,
        chance={one.key: reached for one, reached in zip(data.candidates, chance, strict=True)},
        threshold=effect_threshold(chance, visible),
        contact=contact,
        contact_threshold=least,
        contact_threshold_without_best_joint=least_without,
    )


def contact_thresholds(hypothesis: Hypothesis) -> tuple[float, float]:
    """What a contact's evidence, and what is left of it without its strongest joint, must exceed."""
    scans = over_surrogates(hypothesis, lambda responses: scan_contacts(hypothesis, responses))
    pushes = np.concatenate([scan.evidence for scan in scans])
    weaker = np.concatenate([scan.evidence_without_best_joint for scan in scans])
    return contact_threshold(pushes), contact_threshold(weaker)


def _visible(hypothesis: Hypothesis, scores: LeftOutGains) -> Array:
    """The share (C,) of each candidate's columns outside the baseline; none of the friction of a joint at rest."""
    visible = scores.visible.copy()
    visible[[hypothesis.problem.is_friction_of_resting_joint(c) for c in hypothesis.data.candidates]] = 0.0
    return visible


def surrogate_responses(hypothesis: Hypothesis) -> Array:
    """Responses (M, n, S) without any effect: noise like the residual, and parameters as uncertain as the model's are."""
    return np.concatenate(over_surrogates(hypothesis, lambda responses: responses), axis=2)


def over_surrogates(hypothesis: Hypothesis, function: Callable[[Array], R]) -> list[R]:
    """What a function makes of the same responses (M, n, s), as many at a time as fit into the memory that a search may take, on all
    processors."""
    problem, now = hypothesis.problem, hypothesis.fit
    known = np.flatnonzero(problem.freedom.prior > 0)
    rng = np.random.default_rng([problem.seed, 11])
    x = np.zeros((len(hypothesis.baseline.prior), SURROGATES))
    if len(known):
        x[known] = rng.standard_normal((len(known), SURROGATES)) / np.sqrt(hypothesis.baseline.prior[known])[:, None]
    residual, regressor = now.residual / now.deflation, hypothesis.data.regressor
    at_once = min(SURROGATES, max(FEWEST, AT_ONCE // residual.nbytes))
    parts = EVEN * math.ceil(SURROGATES / at_once / EVEN)  # the same on any machine, so that its numbers are

    def of_some(some: slice) -> R:
        noise = phase_randomised(residual, regressor.segment, SURROGATES, problem.seed, some)
        for rows in steps(len(noise)):
            if len(known):
                noise[rows] += hypothesis.baseline.some_torque(rows, x[:, some])
            noise[rows] *= regressor.counted[rows][:, :, None]
        return function(noise)

    return mapped(of_some, list(blocks(SURROGATES, math.ceil(SURROGATES / parts))))
