"""What an effect loses on the rows that a search hardly counts: those near standstill, where no model is certain of dry friction.

Friction that turns with speed is followed by no law exactly. Bristles, for instance, can describe the tails of a wide turn, which count, and err at
the turn itself, which does not; the model without them was nearer on both together.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.members import where_it_shows, without_effects
from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.problem.folds import OUTSIDE, blocks
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.intervals import resampled_reduction

LOST = "it predicts rows near a reversal, which count little, so much worse that it predicts all rows together worse"


def loses_near_reversals(hypothesis: Hypothesis, accepted: AcceptedEffect) -> bool:
    """Whether an accepted effect enlarges the left-out error where it shows once all rows in motion count alike, by its interval over blocks.

    Not asked of contacts, nor where all recordings are compared: what friction does near standstill is then part of both.
    """
    if accepted.candidate is CONTACT or hypothesis.problem.all_compared:
        return False
    own = hypothesis.accepted.index(accepted)
    labels = blocks(hypothesis.data, float(hypothesis.fit.memory.max()))
    weights = where_it_shows(hypothesis, [own]) / hypothesis.fit.sigma**2
    without, with_it = (_squares(one, labels) @ weights for one in (without_effects(hypothesis, [own]), hypothesis))
    return resampled_reduction(without, with_it, hypothesis.problem.seed)[1] < 0


def _squares(hypothesis: Hypothesis, labels: NDArray[np.intp]) -> NDArray[np.float64]:
    """The squared left-out residual (G, n) [(N m|N)^2] of each block, every row in motion counted alike."""
    residual = hypothesis.left_out_fits.residual() / hypothesis.problem.weights - hypothesis.rest_friction
    inside, result = labels != OUTSIDE, np.zeros((labels.max() + 1, residual.shape[1]))
    np.add.at(result, labels[inside], (residual**2 * hypothesis.data.regressor.counted)[inside])
    return result
