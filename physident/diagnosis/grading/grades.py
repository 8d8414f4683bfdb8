"""The grade of a finding: a cause takes more of the error where it shows than the final model leaves there, and can be noticed."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.members import members, weighted_rows, where_it_shows, without
from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.remainder.unexplained import Unexplained
from physident.diagnosis.result.findings import Finding, Grade, ParameterValue
from physident.diagnosis.search.forward_search import HANDFUL
from physident.diagnosis.search.hypothesis import Hypothesis, rows_during
from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import ShapeParameter
from physident.estimation.estimate import Estimate

Array = NDArray[np.float64]
NOTICED = 0.05  # of the power of what the model errs by on a joint: below on all of them, no RMS error falls by more than 2.5 %
NOTICED_WHILE = 0.25  # the same while a contact lasts: its moment is the best of many
SHAPED = 2.0  # times what it leaves: along the same motions what is left has changed as well, so a law that leaves more has another shape
NEEDLESS = "left-out rows are predicted no worse without it"
AS_HEALTHY = "what the model errs by along healthy recordings looks like such a push, too"
AS_ELSEWHERE = "what the model errs by at other times looks like such a push, too"
HALF_ITS_SHAPE = "along repeated motions a cause takes twice what it leaves: another law may fit better"
UNSURE = "left-out rows may be predicted as well without it"  # beside what was found later, less is left for it than when it was accepted
UNNOTICED = "it is small beside what the model errs by anyway"
BEYOND = "its best shape lies beyond what is physical: another law may fit better"
HOLDS_ZERO = "each of its values may be zero"
ONE_OF_MANY = "it is one of more than a handful"
BESIDE_OTHERS = "left-out rows need it only beside effects that the extended model does not carry"
HOLDS_OLD = "each of its values may be the model's own"


@dataclass(frozen=True, kw_only=True, eq=False)
class ExpectedError:
    """RMS (n,) [N m|N] of the rows of a diagnosis without what is diagnosed: ``right`` is what even a right model leaves there, ``usual``
    what the model errs by anyway, beside which a cause has to be noticed."""

    right: Array
    usual: Array


def expected_error(
    hypothesis: Hypothesis,
    estimate: Estimate | None,
    noise_floor: Array | None,
    unexplained: Sequence[Unexplained],
    wander: Columns | None = None,
) -> ExpectedError:
    """Noise of the torque, what does not repeat, and, where the question is what changed, what the model left on its own
    recordings. Where all recordings are compared that was taken off, and is only what is usual; what remains ``unexplained`` there
    without more memory than noise does not repeat either, nor does what friction and offsets ``wander`` by from day to day."""
    problem = hypothesis.problem
    noise = problem.torque_noise if noise_floor is None else np.maximum(problem.torque_noise, noise_floor)
    if estimate is None or problem.question != "different":
        return ExpectedError(right=noise, usual=noise)
    usual = np.maximum(noise, estimate.sigma)
    if not problem.all_compared:
        return ExpectedError(right=usual, usual=usual)
    unrepeated = np.array([0.0 if one.structured else one.rms for one in unexplained])
    of_the_day = np.zeros(len(noise))
    if wander is not None:
        rows = np.maximum(weighted_rows(hypothesis), 1e-300)
        of_the_day = np.sqrt([np.sum(values**2) / many for (_, values), many in zip(wander.joints, rows, strict=True)])
    return ExpectedError(right=np.hypot(np.maximum(noise, unrepeated), of_the_day), usual=usual)


def graded(
    hypothesis: Hypothesis,
    findings: Sequence[Finding],
    expected: ExpectedError,
    pushed_as_usual: Mapping[str, str] | None = None,
) -> tuple[Finding, ...]:
    """The findings with their grades, causes first, each in order of what it takes. Contacts in recordings that are ``pushed_as_usual``, by which reason, are hints.

    A finding none of whose values is certainly other than before is vague, whatever a control says: of several values it then is a torque that
    differs, and not the named cause. The level of a curve, which an offset or gravity may take, makes none vague.
    """
    why = pushed_as_usual or {}
    doubted = [
        replace(f, doubts=(*f.doubts, why[f.recording])) if f.intervals and f.recording in why else f for f in findings
    ]
    return in_order([_graded(hypothesis, finding, expected) for finding in doubted])


def in_order(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """The findings by grade, each grade in order of evidence."""
    order: dict[Grade, int] = {"cause": 0, "contribution": 1, "hint": 2}
    return tuple(sorted(findings, key=lambda f: (order[f.grade], -f.evidence)))


def is_patchwork(overfull: bool, controlled: bool, compared: bool, findings: Sequence[Finding]) -> bool:
    """Whether the ``findings`` of a search that found more than a handful would prove nothing. Where the search was ``controlled``,
    each of them was held against the control by itself, and only those that changed are left: these must be more than a handful.
    Where all recordings are ``compared``, no baseline is wrong: its error was taken off."""
    return overfull and not compared and (not controlled or len(findings) > HANDFUL)


def single_cause(findings: Sequence[Finding], ordinary: Collection[str] = ()) -> tuple[Finding, ...]:
    """The findings of a search that was stopped: the first cause stays one, contacts too, and all others are contributions.

    Causes that any arm has and the model lacks, of the ``ordinary`` names, such as friction, stay, too: they were not searched for. So do
    causes that make nearly the same torque as such a one on any motion: friction has the name of one law or the other.
    """

    def stays(one: Finding) -> bool:
        same = {one.effect, *(rival.effect for rival in one.rivals if rival.inseparable)}
        return bool(one.intervals) or not same.isdisjoint(ordinary)

    best = next((f for f in findings if f.grade == "cause" and not stays(f)), None)
    return tuple(
        replace(f, grade="contribution", no_cause=ONE_OF_MANY)
        if f.grade == "cause" and f is not best and not stays(f)
        else f
        for f in findings
    )


def _graded(hypothesis: Hypothesis, finding: Finding, expected: ExpectedError) -> Finding:
    problem, sigma = hypothesis.problem, hypothesis.fit.sigma
    where = np.ones(len(sigma)) if finding.intervals else where_it_shows(hypothesis, members(hypothesis, finding))
    # errors are those of rows weighted by what their rests leave open, so the noise is too
    rows = weighted_rows(hypothesis)
    weights = where * rows / sigma**2
    right, usual = (float(np.sum(weights * level**2) / np.sum(weights)) for level in (expected.right, expected.usual))
    whole = _Share.of(finding.gain.rms_before**2, finding.gain.rms_after**2, right)
    share = noticed = _Share.of(*_while_it_lasts(hypothesis, finding), right) if finding.intervals else whole
    shown = (
        noticed.takes / usual if finding.intervals else _shown(whole.takes, where, rows / sigma**2, expected.usual**2)
    )
    if (
        finding.intervals and not share.takes > share.leaves
    ):  # a moment that other errors spoil can still explain the whole
        share = whole
    # a curve is known but for what other parameters take as well; its shape was proved on left-out rows, and so was one value together
    # with its shape, for which another shape and value may stand
    fields = {shape.field for shape in _shapes_of(finding)}
    known = [v for v in finding.parameters if v.std > 0 and not finding.curves]
    shapes, sizes = ([v for v in known if (v.name in fields) is is_shape] for is_shape in (True, False))
    holds_old = len(sizes) > len(shapes) and all(v.change_interval95[0] < 0 < v.change_interval95[1] for v in sizes)
    least = NOTICED_WHILE if finding.intervals else NOTICED
    enough = SHAPED if problem.all_compared and not finding.intervals else 1.0
    against = {
        HALF_ITS_SHAPE: share.takes <= enough * share.leaves,
        UNSURE: finding.gain.interval95[0] <= 0 and not finding.intervals,  # no other block knows of a contact
        UNNOTICED: shown <= least,
        BEYOND: _beyond_bounds(finding, hypothesis),
        HOLDS_ZERO if problem.question == "missing" else HOLDS_OLD: holds_old,
    }
    doubts = finding.doubts or (() if share.takes > 0 else (NEEDLESS,))
    grade: Grade = "hint" if doubts else "contribution" if any(against.values()) else "cause"
    told = grade == "contribution" and share.takes > share.leaves  # else the numbers say it
    scale = 100 / share.before if share.before > 0 else 0.0
    return replace(
        finding,
        grade=grade,
        doubts=doubts,
        takes_percent=scale * share.takes,
        leaves_percent=scale * share.leaves,
        no_cause=next(reason for reason, holds in against.items() if holds) if told else "",
    )


def _shown(takes: float, where: Array, weights: Array, usual: Array) -> float:
    """The largest share that a finding takes of the ``usual`` (n,) mean square of a joint, where it ``takes`` one of all joints, pooled as
    it shows ``where`` (n,) by ``weights`` (n,), rows in units of the noise: a load that only the wrist feels is noticed there."""
    own = takes * where / np.maximum(weights, 1e-300) * np.sum(where * weights) / max(float(np.sum(where**2)), 1e-300)
    return float(np.max(own / usual))


def _shapes_of(finding: Finding) -> tuple[ShapeParameter, ...]:
    """The shape parameters of a finding's effect."""
    effect = CATALOGUE.get(finding.effect)
    return effect.shape_parameters if effect else ()


def _beyond_bounds(finding: Finding, hypothesis: Hypothesis) -> bool:
    """Whether the data would have a shape of every joint beyond all that is physical: another law may be what they show."""
    effect = CATALOGUE.get(finding.effect)
    bounded = {shape.field: shape for shape in _shapes_of(finding) if shape.bounded}
    shapes = [v for v in finding.parameters if v.name in bounded]
    if effect is None or not shapes:
        return False
    robot = hypothesis.problem.model.robot

    def beyond(v: ParameterValue) -> bool:
        tried, end = effect.search_grid(robot, (v.joint,), bounded[v.name]), bounded[v.name].bounded
        return v.at_end and (v.value > tried[-1] / 2 if end == "last" else v.value < 2 * tried[0])

    return all(beyond(v) for v in shapes)


@dataclass(frozen=True, kw_only=True)
class _Share:
    """What a finding ``takes`` of a mean square ``before`` [(N m|N)^2], and what it ``leaves`` above what a right model leaves."""

    before: float
    takes: float
    leaves: float

    @staticmethod
    def of(before: float, after: float, right: float) -> _Share:
        return _Share(before=before, takes=max(0.0, before - after), leaves=max(0.0, after - right))


def _while_it_lasts(hypothesis: Hypothesis, finding: Finding) -> tuple[float, float]:
    """Mean square [(N m|N)^2] that is left without and with a contact in its intervals: it lasts a moment, and what the joints
    leave at all other times says nothing about it. Forces fitted to a few samples are counted by the samples that are left, and only
    those forces that the data tell from their prior: a planar arm feels none across its plane."""
    problem, sigma = hypothesis.problem, hypothesis.fit.sigma
    rows = rows_during(problem, finding.recording, finding.intervals)
    counted = problem.regressor.counted[rows]
    total = max(float((counted * problem.weights[rows] ** 2 / sigma**2).sum()), 1e-300)
    left = (without(hypothesis, [finding]), hypothesis)
    before, after = (float((counted * (one.fit.residual[rows] / sigma) ** 2).sum()) / total for one in left)
    # the well-determined parameters of MacKay, "Bayesian interpolation" (1992)
    forces = sum(float(np.sum(1 - hypothesis.left_to_prior(i))) for i in members(hypothesis, finding))
    samples = float((counted.sum(axis=0) / hypothesis.fit.memory).sum())
    return before, min(before, after / max(1 - forces / max(samples, 1e-300), 1e-300))
