"""What was found, graded beside what the extended model keeps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.grades import NEEDLESS, expected_error, graded, in_order
from physident.diagnosis.grading.members import decides_values, with_changes, without
from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.remainder.unexplained import Unexplained, describe_unexplained
from physident.diagnosis.result.assemble import make_findings
from physident.diagnosis.result.findings import Finding
from physident.diagnosis.rivals.rivals import RivalCheck
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.stability.trust import Trust
from physident.diagnosis.statistics.intervals import Uncertainty, uncertainty_of
from physident.diagnosis.statistics.noise_floor import noise_floor
from physident.diagnosis.statistics.stored_products import Key
from physident.estimation.estimate import Estimate


@dataclass(frozen=True, kw_only=True, eq=False)
class Graded:
    """Graded findings, the ``hypothesis`` without those that are hints, the ``uncertainty`` of its values, and what it leaves."""

    findings: tuple[Finding, ...]
    hypothesis: Hypothesis
    uncertainty: Uncertainty
    unexplained: tuple[Unexplained, ...]
    noise_floor: NDArray[np.float64] | None


def graded_beside_what_stays(
    hypothesis: Hypothesis,
    checks: Sequence[RivalCheck],
    trust: Mapping[Key, Trust],
    sizes: Mapping[Key, float],
    estimate: Estimate | None,
    wander: Columns | None = None,
    from_currents: bool = False,
    hints: Sequence[Finding] = (),
    pushed_as_usual: Mapping[str, str] | None = None,
) -> Graded:
    """The accepted effects as findings, graded without the hints, which the extended model does not carry: a hint takes up no part of a
    cause, unless it decides the values of others.

    ``sizes`` of changes are those of ``changes_since``, ``wander`` is what values are uncertain by beside noise; ``hints`` are known already, and recordings that are ``pushed_as_usual``, by which reason. Of several findings that left-out rows do not need, the one of least evidence goes first: without it the next may be needed.
    """
    problem, hypothesis = hypothesis.problem, without(hypothesis, hints)
    alike = frozenset(key for key, size in sizes.items() if size == 0)
    while True:
        stays = [check for check in checks if any(check.accepted is one for one in hypothesis.accepted)]
        uncertainty, unexplained = uncertainty_of(hypothesis, wander), describe_unexplained(hypothesis)
        found = make_findings(hypothesis, stays, uncertainty, from_currents, trust, alike)
        floor = noise_floor(problem.regressor, problem.signals, hypothesis.torque, hypothesis.residual)
        expected = expected_error(hypothesis, estimate, floor, unexplained, wander)
        findings = graded(hypothesis, with_changes(found, sizes), expected, pushed_as_usual)
        doubtful = [one for one in findings if one.grade == "hint" and not decides_values(hypothesis, one)]
        doubted = [finding for finding in doubtful if finding.doubts != (NEEDLESS,)]
        leaving = doubted or sorted(doubtful, key=lambda finding: finding.evidence)[:1]
        if len(leaving) in (0, len(findings)):
            break
        hints = (*hints, *leaving)
        hypothesis = without(hypothesis, leaving)
    return Graded(
        findings=in_order((*findings, *hints)),
        hypothesis=hypothesis,
        uncertainty=uncertainty,
        unexplained=unexplained,
        noise_floor=floor,
    )
