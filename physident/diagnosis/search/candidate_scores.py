"""How well each candidate does on left-out rows, beside what it reaches by chance on surrogates of the residual."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.search.contact_scan import ContactScan, scan_contacts
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.thresholds import SURROGATES, contact_threshold, effect_threshold
from physident.diagnosis.statistics.left_out_gains import LeftOutGains, left_out_gains
from physident.diagnosis.statistics.surrogates import phase_randomised
from physident.identifiability.visibility import VISIBLE

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class CandidateScores:
    """Scores of all candidates beside a hypothesis.

    ``gain`` (C,): evidence on left-out rows; ``evidence_without_best_fold`` (C,): the same without the fold that supports it
    most; ``visible_share`` (C,) of a candidate's columns outside the baseline; ``threshold``: what the best candidate
    reaches by chance. ``contact`` is the best contact, with thresholds of its own for its evidence and for its evidence
    without its strongest joint.
    """

    hypothesis: Hypothesis
    gain: Array
    evidence_without_best_fold: Array
    visible_share: Array
    threshold: float
    contact: ContactScan
    contact_threshold: float
    contact_threshold_without_best_joint: float

    def beats_chance(self, index: int) -> bool:
        """Whether a candidate can be seen at all and beats the threshold even without its best fold."""
        return self.visible_share[index] >= VISIBLE and self.evidence_without_best_fold[index] > self.threshold


def rescore_candidates(hypothesis: Hypothesis, before: CandidateScores) -> CandidateScores:
    """Score every candidate beside a hypothesis against the thresholds of earlier scores, without new surrogates."""
    data, baseline, fit = hypothesis.data, hypothesis.baseline, hypothesis.fit
    response = data.response[:, :, None]
    scores = left_out_gains(data, baseline, fit, response)
    return replace(
        before,
        hypothesis=hypothesis,
        gain=scores.evidence[:, 0],
        evidence_without_best_fold=scores.evidence_without_best_fold[:, 0],
        visible_share=_visible(hypothesis, scores),
        contact=scan_contacts(hypothesis, response),
    )


def score_candidates(hypothesis: Hypothesis) -> CandidateScores:
    """Score every candidate beside a hypothesis, and surrogates of its residual in the same way."""
    data, baseline, fit = hypothesis.data, hypothesis.baseline, hypothesis.fit
    responses = np.concatenate([data.response[:, :, None], surrogate_responses(hypothesis)], axis=2)
    scores = left_out_gains(data, baseline, fit, responses)
    visible = _visible(hypothesis, scores)
    stable, contact = scores.evidence_without_best_fold, scan_contacts(hypothesis, responses)
    return CandidateScores(
        hypothesis=hypothesis,
        gain=scores.evidence[:, 0],
        evidence_without_best_fold=stable[:, 0],
        visible_share=visible,
        threshold=effect_threshold(stable[:, 1:], visible),
        contact=contact,
        contact_threshold=contact_threshold(contact.evidence[1:]),
        contact_threshold_without_best_joint=contact_threshold(contact.evidence_without_best_joint[1:]),
    )


def _visible(hypothesis: Hypothesis, scores: LeftOutGains) -> Array:
    """The share (C,) of each candidate's columns outside the baseline; none of the friction of a joint at rest."""
    visible = scores.visible.copy()
    visible[[hypothesis.problem.is_friction_of_resting_joint(c) for c in hypothesis.data.candidates]] = 0.0
    return visible


def surrogate_responses(hypothesis: Hypothesis) -> Array:
    """Responses (M, n, S) without any effect: noise like the residual, and parameters as uncertain as the model's are."""
    problem, now = hypothesis.problem, hypothesis.fit
    noise = phase_randomised(now.residual / now.deflation, hypothesis.data.regressor.segment, SURROGATES, problem.seed)
    known = np.flatnonzero(problem.freedom.prior > 0)
    if len(known):
        rng = np.random.default_rng([problem.seed, 11])
        x = rng.standard_normal((len(known), SURROGATES)) / np.sqrt(hypothesis.baseline.prior[known])[:, None]
        for j, B in enumerate(hypothesis.baseline.joints):
            noise[:, j] += B[:, known] @ x
    return noise * hypothesis.data.regressor.counted[:, :, None]
