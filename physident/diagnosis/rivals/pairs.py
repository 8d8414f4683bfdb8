"""Rivals of two: an effect that is a special case without another of its joint, such as a spring that is relaxed somewhere."""

from __future__ import annotations

from dataclasses import replace

from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.search.acceptance import contradiction, is_as_good, makes_redundant
from physident.diagnosis.search.hypothesis import Array, Hypothesis
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.statistics.left_out_gains import left_out_gains


def rivals_of_two(
    rest: Hypothesis, accepted: Candidate, cost: Array, weights: Array, chi_squared: float, threshold: float
) -> tuple[Candidate, ...]:
    """The candidates that stand in the place of an accepted one together with what they go with, both of fewer numbers than it.

    ``rest`` is the hypothesis without the accepted candidate, ``cost`` (G, n) and ``chi_squared`` are what it leaves of left-out and of earlier
    rows, with the ``weights`` (n,) of the joints. Alone, such a candidate would have to be right at zero, and is no rival.
    """
    places, found = {one.key: one for one in rest.data.candidates}, []
    for other in rest.data.candidates:
        effect = other.options[0].effect
        companion = places.get((effect.goes_with, other.joints)) if effect is not None and effect.goes_with else None
        if companion is None or accepted in (other, companion) or other.size + companion.size >= accepted.size:
            continue
        beside = rest.with_effect(companion, refine_shape(rest, companion))
        data = replace(beside.data, candidates=(other,))
        gain = left_out_gains(data, beside.baseline, beside.fit, products=beside.products).evidence[0, 0]
        if (
            gain >= threshold
            and is_as_good(beside, other, cost, weights, chi_squared)
            and makes_redundant(beside, other, accepted, threshold)
            and contradiction(beside, other) is None
        ):
            found.append(other)
    return tuple(found)
