"""Whether these recordings refute that another effect stands in the place of a found one, though both make nearly the same torque."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.baseline_fit import fit_baseline
from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.left_out_costs import RIVAL_STANDARD_ERRORS
from physident.diagnosis.statistics.baseline_products import BaselineProducts
from physident.diagnosis.statistics.left_out_residuals import standard_error

Array = NDArray[np.float64]
TWICE = 2.0  # times what is left with the found effect: what the other one cannot make is then more than noise and all else that the model lacks


def is_refuted(found: Array, instead: Array) -> bool:
    """Whether left-out costs (G, n) of blocks are larger beyond chance with another effect ``instead``, and twice as large on a joint."""
    loss = (instead - found).sum(axis=1)
    beyond_chance = loss.sum() > RIVAL_STANDARD_ERRORS * standard_error(loss)
    return bool(beyond_chance and (instead.sum(axis=0) > TWICE * found.sum(axis=0)).any())


def costs_with(rest: Hypothesis, torque: Array, weights: Array) -> Array:
    """Left-out costs (G, n) by some ``weights`` (n,) where a multiple of a ``torque`` (M, n), in weighted rows, joins a hypothesis."""
    baseline = rest.baseline.joined(Columns.of([column[:, None] for column in torque.T]))
    fit = fit_baseline(rest.data, baseline, BaselineProducts(rest.data, baseline).equations)
    return weights**2 * replace(rest, baseline=baseline, fit=fit).left_out_squares
