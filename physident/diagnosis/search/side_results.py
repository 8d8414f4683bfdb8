"""What a search says beside its findings: how placebos fared, and which effects could not be seen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from physident.diagnosis.problem.candidates import candidate_effects
from physident.diagnosis.result.findings import Placebo, Unseen, UnseenReason
from physident.diagnosis.search.candidate_scores import CandidateScores
from physident.diagnosis.statistics.stored_products import Key
from physident.errors import NotSolvedError
from physident.identifiability.visibility import VISIBLE

SILENT = 1e-9  # N m a unit: rounding
INSIDE: Final = "inside what the baseline may take up"


def placebos_of(last: CandidateScores) -> tuple[Placebo, ...]:
    """The evidence of columns that cannot be causes, beside what a cause needs."""
    return tuple(
        Placebo(c.name, c.joints[0], float(gain), last.threshold)
        for c, gain in zip(last.hypothesis.data.candidates, last.evidence_without_best_fold, strict=True)
        if c.placebo
    )


def refuse_if_placebos_pass(placebos: Sequence[Placebo]) -> None:
    """Where columns that cannot be causes all pass as causes, no answer on these recordings means anything."""
    if placebos and all(placebo.passed for placebo in placebos):
        raise NotSolvedError(
            f"all {len(placebos)} placebos, which cannot be causes, exceed the threshold: these recordings cannot be judged;"
            " inspect them, or record longer motions"
        )


def unseen_effects(first: CandidateScores) -> tuple[Unseen, ...]:
    """Effects that lie inside the baseline, show no torque, or need a wider motion, when the search begins."""
    hypothesis = first.hypothesis
    places = candidate_effects(hypothesis.problem.model, hypothesis.problem.signals)
    # without a joint it is one that scales what the model does not have
    result = [
        Unseen(name, joints, "of a joint that moves too little")
        for name, joints, options in places
        if joints and not options
    ]
    for candidate, share in zip(hypothesis.data.candidates, first.visible_share, strict=True):
        if share >= VISIBLE or candidate.placebo:
            continue
        columns = hypothesis.data.columns(candidate.options[0].columns)
        silent = max(float(np.abs(values).max(initial=0.0)) for _, values in columns.joints) < SILENT
        reason: UnseenReason = "shows no torque" if silent else INSIDE
        if hypothesis.problem.is_friction_of_resting_joint(candidate):
            reason = "of a joint that does not move"
        result.append(Unseen(candidate.name, candidate.joints, reason))
    return tuple(result)


def inside_baseline(first: CandidateScores) -> list[Key]:
    """Name and joints of the effects that lie inside the baseline when the search begins."""
    return [(one.effect, one.joints) for one in unseen_effects(first) if one.reason == INSIDE]
