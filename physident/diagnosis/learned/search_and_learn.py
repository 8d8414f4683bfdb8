"""The whole search, once more where what it finds is most of what the residual remembered.

How many rows are worth one sample is read from what all candidates at once leave. A torque that none of them describes is part of
that, and remembers as long as the motion does: a minute of a slow cable then counts as nine samples, in blocks so long that none is
left to find it in. Beside what was found, the memory is the noise's. What proves a curve is not the memory, which sets only which rows
are left out together, but surrogates that remember as long as the residual did without the curve.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.learned.learn import joints_with_structure, learn_curves
from physident.diagnosis.learned.pool import AMPLITUDES, CurvePool
from physident.diagnosis.problem.baseline_fit import fit_with_all_candidates
from physident.diagnosis.problem.problem import DiagnosisProblem, with_memory
from physident.diagnosis.problem.search_data import Baseline
from physident.diagnosis.remainder.unexplained import STRUCTURED, white_memory
from physident.diagnosis.search.candidate_scores import score_candidates
from physident.diagnosis.search.forward_search import SearchResult
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.search.turning_speeds import search_with_turning_speeds
from physident.effects.learned.curve import LearnedCurve
from physident.estimation.uncertainty import correlation_rows

Array = NDArray[np.float64]
SHORTER = 0.5  # of the rows that were remembered: a sum of autocorrelations scatters by half of it
LITTLE = 0.1  # of what all candidates leave of a joint's power: a memory is that of most of the power, so it was that of what was found
STATE = ("position", "velocity", "load", "torque")  # of curves that are none over time, which takes any slow noise


def search_and_learn(problem: DiagnosisProblem, progress: Callable[[str], None] = lambda _: None) -> SearchResult:
    """The effects and curves that the recordings of a problem show."""
    found = learn_curves(search_with_turning_speeds(problem, progress), progress)
    if problem.freedom.compared and not problem.all_compared:  # the memory is that of compared recordings alone
        return found
    first = found if _curves(found) else _learned_in_shorter_blocks(found, progress)
    if not first.accepted:
        return found
    sharper = _with_less_memory(problem, first.last.hypothesis, first.last.hypothesis.baseline)
    if sharper is None:
        return found
    progress("noise remembers less beside what was found: searching again")
    return learn_curves(search_with_turning_speeds(sharper, progress), progress)


def _learned_in_shorter_blocks(found: SearchResult, progress: Callable[[str], None]) -> SearchResult:
    """A search that found no curve, with curves that it finds in blocks as long as what curves of every quantity at once leave
    remembers."""
    now = found.last.hypothesis
    joints = [] if found.overfull else joints_with_structure(now)
    if not joints:
        return found
    sharper = _with_less_memory(now.problem, now, _with_every_curve(now, CurvePool.of(now, joints)))
    if sharper is None:
        return found
    scores = score_candidates(state_hypothesis(sharper, found.accepted, now.model))
    return learn_curves(replace(found, last=scores), progress)


def _with_every_curve(now: Hypothesis, pool: CurvePool) -> Baseline:
    """The baseline of a hypothesis with a curve of each quantity on each joint of a pool, all of one amplitude."""
    baseline, sigma = now.baseline, now.fit.sigma
    for curve in pool.curves:
        if curve.effect.variable in STATE:
            (option,) = curve.candidate(AMPLITUDES[1], float(sigma[curve.joint - 1])).options
            baseline = baseline.joined(pool.data.columns(option.columns), option.prior)
    return baseline


def _with_less_memory(problem: DiagnosisProblem, now: Hypothesis, baseline: Baseline) -> DiagnosisProblem | None:
    """The problem with the memory of what all candidates leave beside a baseline; None where that is not much shorter, or where the joint that
    remembers longest keeps more than noise or a little of its residual: a model that lacks other things, too, remembers these."""
    data = problem.search_data(now.model)
    before, left = (fit_with_all_candidates(data, one).residual for one in (problem.baseline(data), baseline))
    memory, longest = correlation_rows(problem.regressor, left), int(np.argmax(problem.memory))
    is_little = np.sum(left[:, longest] ** 2) < LITTLE * np.sum(before[:, longest] ** 2)
    is_noise = memory[longest] < STRUCTURED * white_memory(now)
    much_less = memory.max() < SHORTER * problem.memory.max()
    return with_memory(problem, memory) if much_less and (is_little or is_noise) else None


def _curves(found: SearchResult) -> Sequence[LearnedCurve]:
    return [one.effect for one in found.accepted if isinstance(one.effect, LearnedCurve)]
