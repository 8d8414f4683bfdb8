"""The curves that a diagnosis can try: one of each quantity on each joint, with several amplitudes of its prior; and placebos."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import Candidate, Option, PlaceboCandidate, played_backwards
from physident.diagnosis.problem.problem import DiagnosisProblem
from physident.diagnosis.problem.search_data import SearchData
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.dynamics.regressor import JointRows, Regressor, build_regressor
from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import Detection
from physident.effects.learned.curve import LearnedCurve
from physident.estimation.weighting import weight_rows
from physident.large_arrays import empty, steps

Array = NDArray[np.float64]
AMPLITUDES = (1.0, 6.0, 36.0, 216.0)  # times what a joint leaves: of a drift, of a bend, of a bump, of many waves
PLACEBO = "placebo_curve"


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve of one quantity on one joint (from 1) without an amplitude, and its columns in the regressor."""

    effect: LearnedCurve
    joint: int
    columns: tuple[int, ...]

    def candidate(self, factor: float, left: float) -> Candidate:
        """The candidate with an amplitude of a ``factor`` times what its joint has ``left`` [N m|N]."""
        effect = replace(self.effect.beside((left,)), amplitude=(factor * left,))
        return Candidate(effect.name, (self.joint,), (Option(effect, self.columns),))


@dataclass(frozen=True, eq=False)
class CurvePool:
    """A ``problem``, and the ``data`` of a hypothesis, whose regressor also has the columns of some ``curves``, and of ``placebos``: as
    many columns, of the motion played backwards."""

    problem: DiagnosisProblem
    data: SearchData
    curves: tuple[Curve, ...]
    placebos: tuple[Curve, ...]

    @staticmethod
    def of(hypothesis: Hypothesis, joints: Sequence[int]) -> CurvePool:
        """The curves of some joints (from 1) beside a hypothesis, those of its load as its model computes it."""
        problem, robot = hypothesis.problem, hypothesis.problem.model.robot
        signals = problem.referred(hypothesis.model)
        shown = [*signals, *(signals[k] for k in sorted(problem.freedom.compared))]  # the control is of the same motion
        effects = [
            cls((j,)).placed(robot, signals)
            for cls in CATALOGUE.values()
            if cls.detection is Detection.AFTER_LAWS
            for j in joints
            if j not in problem.resting_joints and not _has(problem, cls.name, j) and cls.is_shown(shown, j - 1)
        ]
        added = weight_rows(build_regressor(robot, effects, signals, problem.filter), problem.weights)
        first, at, curves, placebos = len(problem.regressor.columns), 0, [], []
        count = len(added.columns)
        for effect in effects:
            (joint,), k = effect.joints or (0,), len(effect.columns(robot))
            curves.append(Curve(effect, joint, tuple(range(first + at, first + at + k))))
            placebos.append(Curve(effect, joint, tuple(range(first + count + at, first + count + at + k))))
            at += k
        data = replace(hypothesis.data, regressor=_joined(hypothesis.data.regressor, added), kept={})
        return CurvePool(replace(problem, regressor=data.regressor), data, tuple(curves), tuple(placebos))

    def candidates(self, hypothesis: Hypothesis, joints: Sequence[int] | None = None) -> list[Candidate]:
        """Every curve on some joints (from 1), by default all, with every amplitude; curves that were accepted are left out."""
        taken = {one.candidate.key for one in hypothesis.accepted}
        sigma = hypothesis.fit.sigma
        return [
            curve.candidate(factor, float(sigma[curve.joint - 1]))
            for curve in self.curves
            if (joints is None or curve.joint in joints) and (curve.effect.name, (curve.joint,)) not in taken
            for factor in AMPLITUDES
        ]

    def placebo_candidates(self, hypothesis: Hypothesis) -> list[Candidate]:
        """The placebos, each with every amplitude."""
        sigma = hypothesis.fit.sigma
        return [
            PlaceboCandidate(PLACEBO, (one.joint,), (Option(None, one.columns, tuple(option.prior)),))
            for one in self.placebos
            for factor in AMPLITUDES
            for option in one.candidate(factor, float(sigma[one.joint - 1])).options
        ]

    def with_only(self, before: DiagnosisProblem, chosen: Sequence[Candidate]) -> DiagnosisProblem:
        """The problem as it was ``before``, with some curves as its last candidates, their columns after those of all others."""
        source, target = self.problem.regressor, before.regressor
        behind = [*before.freedom.nuisance, *(k for one in before.placebos for k in one.options[0].columns)]
        first = len(target.columns) - len(behind)
        wanted = [column for candidate in chosen for option in candidate.options for column in option.columns]
        place = {column: first + k for k, column in enumerate(wanted)}
        joints = []
        for rows, more in zip(target.joints, source.joints, strict=True):
            taken = [k for k, column in enumerate(more.columns) if int(column) in place]
            kept = np.where(rows.columns < first, rows.columns, rows.columns + len(wanted))
            columns = np.concatenate([kept, [place[int(more.columns[k])] for k in taken]]).astype(np.intp)
            values = empty((len(columns), len(target.time))).T
            for some in steps(len(values)):
                values[some] = np.column_stack([rows.some(some), more.some(some)[:, taken]])
            joints.append(JointRows(columns, values))
        names = (*target.columns[:first], *(source.columns[c] for c in wanted), *target.columns[first:])
        candidates = [_moved(c, place) for c in chosen]
        further = {column: column + len(wanted) for column in behind}
        nuisance = tuple(column + len(wanted) for column in before.freedom.nuisance)
        return replace(
            before,
            regressor=replace(target, columns=names, joints=tuple(joints)),
            candidates=(*before.candidates, *candidates),
            placebos=tuple(_moved(one, further) for one in before.placebos),
            freedom=replace(before.freedom, nuisance=nuisance),
        )


def _moved(candidate: Candidate, place: Mapping[int, int]) -> Candidate:
    """A candidate whose columns stand in other places."""
    options = (replace(o, columns=tuple(place[k] for k in o.columns)) for o in candidate.options)
    return replace(candidate, options=tuple(options))


def _has(problem: DiagnosisProblem, name: str, joint: int) -> bool:
    return any(e.name == name and joint - 1 in e.active(problem.model.robot) for e in problem.model.effects)


def _joined(regressor: Regressor, added: Regressor) -> Regressor:
    """A regressor with the columns of another on the same rows, and once more with these played backwards, segment by segment."""
    backward = played_backwards(regressor.segment)
    first, count = len(regressor.columns), len(added.columns)
    joints = []
    for j, (rows, more) in enumerate(zip(regressor.joints, added.joints, strict=True)):
        counted, k, c = regressor.counted[:, j : j + 1], len(rows.columns), len(more.columns)
        columns = np.concatenate([rows.columns, first + more.columns, first + count + more.columns])
        values = empty((len(columns), len(backward))).T
        for some in steps(len(values)):
            values[some, :k] = rows.some(some)
            values[some, k : k + c] = more.some(some) * counted[some]
            values[some, k + c :] = more.some(backward[some]) * counted[some]
        joints.append(JointRows(columns, values))
    return replace(regressor, columns=(*regressor.columns, *added.columns, *added.columns), joints=tuple(joints))
