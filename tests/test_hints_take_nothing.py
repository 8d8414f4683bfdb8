"""A hint is no part of the extended model, so a cause is measured without it: as if the hint had never been found."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.graded import Graded, graded_beside_what_stays
from physident.diagnosis.grading.grades import NEEDLESS
from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.result.assemble import make_findings
from physident.diagnosis.rivals.rivals import RivalCheck
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.stability.trust import Trust
from physident.diagnosis.statistics.intervals import uncertainty_of
from tests.opened import opened

MORE = 8.0  # N m s/rad on joint 3
TRUE, IMITATOR = ("viscous_friction", (3,)), ("nonlinear_viscous_friction", (3,))


@pytest.fixture(scope="module")
def beside(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> Hypothesis:
    """An arm whose joint 3 is braked in proportion to its speed, by more than its model says."""
    v = healthy_runs[2].dq
    assert v is not None
    return opened(ur5, healthy_runs[:3], MORE * v * (np.arange(6) == 2))


def accepted(beside: Hypothesis, *keys: tuple[str, tuple[int, ...]]) -> Hypothesis:
    found = {c.key: c for c in beside.data.candidates}
    each = []
    for key in keys:
        effect = found[key].options[2 if key == IMITATOR else 0].effect  # speed to the power of 0.7: nearly a line
        assert effect is not None
        each.append(AcceptedEffect(found[key], effect))
    return settled_hypothesis(beside.problem, each)


def judged(state: Hypothesis, *doubted: tuple[str, tuple[int, ...]], evidence: Sequence[float] = (9.0, 3.0)) -> Graded:
    checks = [RivalCheck(one, gain, ()) for one, gain in zip(state.accepted, evidence, strict=False)]
    trust = {one: Trust(0.2, ("rarely found",)) for one in doubted}
    return graded_beside_what_stays(state, checks, trust, {}, None)


def test_a_cause_takes_as_much_as_without_the_hint_beside_it(beside: Hypothesis) -> None:
    both = accepted(beside, TRUE, IMITATOR)
    found, alone = judged(both, IMITATOR), judged(accepted(beside, TRUE))
    assert [(f.effect, f.grade) for f in found.findings] == [(TRUE[0], "cause"), (IMITATOR[0], "hint")]
    assert found.findings[0].gain.rms_before == pytest.approx(alone.findings[0].gain.rms_before, rel=1e-3)
    assert found.findings[0].takes_percent == pytest.approx(alone.findings[0].takes_percent, abs=0.1)
    assert found.findings[0].parameters[0].value == pytest.approx(alone.findings[0].parameters[0].value, rel=1e-3)
    beside_the_hint = make_findings(both, [RivalCheck(one, 1.0, ()) for one in both.accepted], uncertainty_of(both))
    taken = next(f for f in beside_the_hint if f.effect == TRUE[0])
    assert taken.gain.rms_before < 0.5 * alone.findings[0].gain.rms_before


def test_what_left_out_rows_do_not_need_takes_nothing_either(beside: Hypothesis) -> None:
    found, alone = judged(accepted(beside, TRUE, IMITATOR)), judged(accepted(beside, TRUE))
    assert [(f.effect, f.grade, f.doubts) for f in found.findings] == [
        (TRUE[0], "cause", ()),
        (IMITATOR[0], "hint", (NEEDLESS,)),
    ]
    assert found.findings[0].takes_percent == pytest.approx(alone.findings[0].takes_percent, abs=0.1)


@pytest.mark.parametrize("first", [0, 1])
def test_of_two_that_make_each_other_needless_the_one_of_more_evidence_stays(beside: Hypothesis, first: int) -> None:
    """Both as hints would leave a torque without a name that either of them explains."""
    state = accepted(beside, TRUE, IMITATOR)
    twins = [AcceptedEffect(one.candidate, state.accepted[0].effect) for one in state.accepted]
    evidence = [9.0, 3.0] if first == 0 else [3.0, 9.0]
    alike = settled_hypothesis(beside.problem, twins)
    found = judged(alike, evidence=evidence)
    assert [f.grade for f in found.findings] == ["cause", "hint"]
    assert found.findings[0].effect == twins[first].candidate.name
