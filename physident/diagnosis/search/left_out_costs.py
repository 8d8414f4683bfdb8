"""What a hypothesis errs by on left-out rows, with a candidate or without one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.thresholds import MIN_REDUCTION_PERCENT

Array = NDArray[np.float64]
RIVAL_STANDARD_ERRORS = 1.645  # of a paired difference: the true cause is then missed as a rival once in twenty


def left_out_costs(hypothesis: Hypothesis, candidate: Candidate | None, weights: Array | None = None) -> Array:
    """Squared left-out residual (G, n) of each block, with a candidate or without any, in units of the hypothesis' noise
    or by other ``weights`` (n,)."""
    weights = hypothesis.fit.weights if weights is None else weights
    if candidate is None:
        return weights**2 * hypothesis.left_out_squares
    if candidate.key not in hypothesis.left_out:
        hypothesis.left_out[candidate.key] = hypothesis.left_out_fits.squares_of_blocks(*_options(candidate))
    return weights**2 * hypothesis.left_out[candidate.key]


def contradicted(hypothesis: Hypothesis, candidate: Candidate | None, first: int | None = None) -> float:
    """By how much the model, or its ``first`` values, contradict what earlier rows said of it, chi squared, with a candidate or without."""
    if not hypothesis.baseline.prior.any():
        return 0.0
    return hypothesis.left_out_fits.contradicted(*_options(candidate), first)


def _options(candidate: Candidate | None) -> tuple[list[tuple[int, ...]], list[Array]]:
    """The columns of each option of a candidate, and the prior precision (k,) of its values."""
    options = candidate.options if candidate else ()
    return [option.columns for option in options], [option.prior for option in options]


def is_worth_naming(hypothesis: Hypothesis, before: Array, after: Array, whole: Array | None = None) -> bool:
    """Whether left-out costs (G, n), in units of a hypothesis' noise, fall by enough of a joint's RMS error to be of practical use: of the
    error ``before``, or of a ``whole`` one of which something else has taken its part."""
    usual = hypothesis.fit.weights**2 * hypothesis.problem.taken_off_squares
    costs = (before if whole is None else whole, before, after)
    most, more, less = (np.sqrt(np.maximum(one.sum(axis=0) + usual, 0.0)) for one in costs)
    return bool(np.max(100 * (more - less) / np.maximum(most, 1e-150)) >= MIN_REDUCTION_PERCENT)
