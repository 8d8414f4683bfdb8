"""One look at all candidates: what each gains on left-out rows, beside what surrogates of the noise gain by chance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.search.contact import Scan, scan
from physident.diagnosis.search.hypothesis import State
from physident.diagnosis.statistics.left_out_gains import gains, shares
from physident.diagnosis.statistics.surrogates import randomised
from physident.identifiability.visibility import VISIBLE

Array = NDArray[np.float64]
SURROGATES = 299  # the 99th percentile is then the third largest
LEVEL = 0.99  # of a hundred clean arms one is accused of an effect, and one of a contact


@dataclass(frozen=True, eq=False)
class Look:
    """One look at all candidates beside a state: left-out evidence ``gain`` (C,), the ``least`` (C,) of it without one fold,
    ``share`` (C,) outside the baseline, the surrogates' ``threshold``, and the best ``contact`` with its own, ``touch``, and
    ``touch_least`` without the joint that speaks most for it."""

    state: State
    gain: Array
    least: Array
    share: Array
    threshold: float
    contact: Scan
    touch: float
    touch_least: float

    def passes(self, index: int) -> bool:
        """Whether a candidate's evidence beats the surrogates' even without the fold that speaks most for it."""
        return bool(self.share[index] >= VISIBLE and self.least[index] > self.threshold)


def look(state: State) -> Look:
    """Judge every candidate beside a state, and the best contact, each by the surrogates' luckiest of its kind."""
    evidence, baseline, now = state.evidence, state.baseline, state.fit
    responses = np.concatenate([evidence.response[:, :, None], surrogates(state)], axis=2)
    found = gains(evidence, baseline, now, responses)
    share = shares(evidence, baseline, now.weights)
    share[[state.case.motionless(c) for c in evidence.candidates]] = 0.0
    least, contact = found.least, scan(state, responses)
    # each by its own: a contact may begin anywhere, and its luckiest beginning is not to be beaten by an effect
    threshold = float(np.quantile(least[share >= VISIBLE].max(axis=0)[1:], LEVEL))
    touch = float(np.quantile(contact.evidence[1:], LEVEL))
    touch_least = float(np.quantile(contact.least[1:], LEVEL))
    return Look(state, found.evidence[:, 0], least[:, 0], share, threshold, contact, touch, touch_least)


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
