"""A hypothesis: some accepted effects beside the model, their joint fit, and what the extended model then is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.baseline_fit import Fit, fit_baseline
from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate, prior_precision
from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.problem.problem import DiagnosisProblem
from physident.diagnosis.problem.search_data import OUTSIDE, Baseline, SearchData
from physident.diagnosis.search.extension import Extension, extend
from physident.diagnosis.statistics.baseline_products import BaselineProducts
from physident.diagnosis.statistics.left_out_residuals import LeftOutFits
from physident.diagnosis.statistics.normal_equations import first_takes_all, pseudo_inverse, undecided
from physident.dynamics.model import Model
from physident.effects.contact import Contact
from physident.effects.effect import Effect
from physident.estimation.dry_friction.rest import rest_rows
from physident.large_arrays import blocks

Array = NDArray[np.float64]
ELSEWHERE = 3.0  # standard errors: noise alone moves a value so far once in 400 times, and a value so much less certain is another answer
NEAR = 0.1  # of a joint's torque: an error of a tenth in a candidate's column costs it a hundredth of its gain


@dataclass(frozen=True, kw_only=True, eq=False)
class Hypothesis:
    """The accepted effects beside the model of a problem, and their joint fit to all rows.

    Columns that depend on a model are evaluated by ``model``; ``data`` holds the candidates that are left, ``baseline``
    the columns of the model and the accepted effects.
    """

    problem: DiagnosisProblem
    accepted: tuple[AcceptedEffect, ...]
    model: Model
    data: SearchData
    baseline: Baseline
    fit: Fit
    refined: dict[tuple[str, tuple[int, ...]], Effect] = field(default_factory=dict, init=False)  # by candidate
    left_out: dict[tuple[str, tuple[int, ...]], Array] = field(
        default_factory=dict, init=False
    )  # squared residuals of blocks, by candidate
    contradictions: dict[tuple[str, tuple[int, ...]], str | None] = field(default_factory=dict, init=False)

    @cached_property
    def products(self) -> BaselineProducts:
        """The products of the baseline's columns, from which gains and costs are computed."""
        return BaselineProducts(self.data, self.baseline)

    @cached_property
    def left_out_fits(self) -> LeftOutFits:
        """The same baseline fitted outside each fold."""
        return LeftOutFits(self.data, self.baseline, self.fit.weights, self.products)

    @cached_property
    def left_out_squares(self) -> Array:
        """Squared residual (G, n) [(N m)^2] of each block, of the baseline fitted outside its fold."""
        return self.left_out_fits.squares_of_blocks()

    @property
    def _model_values(self) -> int:
        """How many of the fit's values belong to the model; those of the accepted effects follow."""
        return len(self.problem.freedom.prior)

    @cached_property
    def _shared_out(self) -> Array:
        """The map (E, E) by which the effect accepted first has what several of them can make."""
        own = self.fit.normal[self._model_values :, self._model_values :]
        return first_takes_all(own, self._sizes)

    @property
    def _sizes(self) -> list[int]:
        """How many values each accepted effect has."""
        return [len(a.effect.columns(self.problem.model.robot)) for a in self.accepted]

    @cached_property
    def effect_values(self) -> list[Array]:
        """Fitted values (k,) of each accepted effect."""
        values = self._shared_out @ self.fit.x[self._model_values :]
        return np.split(values, np.cumsum(self._sizes)[:-1]) if self.accepted else []

    @cached_property
    def extension(self) -> Extension:
        """The model at the values of the joint fit. Beside a comparison the model's own parameters stay: what they take up along other
        motions is what the model lacks there."""
        model, freedom = self.problem.model, self.problem.freedom
        theta = model.theta if freedom.compared else model.theta + freedom.map @ self.fit.x[: self._model_values]
        moved = Model(model.robot, model.effects, theta)
        return extend(moved, [a.effect for a in self.accepted], self.effect_values)

    def torque_of(self, i: int) -> Array:
        """What an accepted effect (its index) adds to the torque (M, n) [N m|N], in rows weighted by what their rests leave open."""
        one = self.accepted[i]
        return self.columns(one.candidate, one.effect).torque(self.effect_values[i])

    @cached_property
    def jacobian(self) -> Array:
        """How the extended model's theta (P,) moves with the values of the joint fit: (P, R)."""
        J = np.zeros((len(self.extension.model.theta), len(self.fit.x)))
        J[: len(self.problem.model.theta), : self._model_values] = self.problem.freedom.map
        for places, rows in zip(self.extension.places, self.places_of_changes, strict=True):
            J[places] += self.jacobian_of_changes[rows]
        return J

    @cached_property
    def jacobian_of_changes(self) -> Array:
        """How the values of all accepted effects, one after the other (E,), move with those of the joint fit: (E, R)."""
        return np.column_stack([np.zeros((len(self._shared_out), self._model_values)), self._shared_out])

    @property
    def places_of_changes(self) -> list[slice]:
        """Where the values of each accepted effect stand among those of all."""
        ends = np.cumsum([0, *self._sizes]).tolist()
        return [slice(start, stop) for start, stop in pairwise(ends)]

    @cached_property
    def covariance(self) -> Array:
        """Covariance (P, P) of the extended model's theta with correlated rows counted as independent samples."""
        return self.jacobian @ pseudo_inverse(self.fit.normal) @ self.jacobian.T

    def standard_errors(self, i: int) -> Array:
        """The standard errors (k,) of the numbers of accepted effect i, with correlated rows counted as independent samples."""
        return np.sqrt(np.diag(self.covariance)[self.extension.places[i]])

    def left_to_prior(self, i: int) -> Array:
        """How much (k,) of the prior variance of each number of accepted effect i the data leave: 1 where they say nothing of it, 0 without a prior."""
        places = self.extension.places[i]
        return prior_precision(self.accepted[i].effect, len(places)) * np.diag(self.covariance)[places]

    def left_open(self, i: int, told: Array) -> NDArray[np.bool_]:
        """Which linear functions ``told`` (r, k) of the numbers of accepted effect i no motion of these recordings shows apart from the others,
        whatever the rest of the arm is."""
        at = self.places_of_changes[i]
        own = slice(self._model_values + at.start, self._model_values + at.stop)
        return undecided(self.fit.normal[own, own], told)

    def with_effect(self, candidate: Candidate, effect: Effect) -> Hypothesis:
        """The same with one effect more; columns that depend on a model stay as they are."""
        columns = self.columns(candidate, effect)
        baseline = self.baseline.joined(columns, prior_precision(effect, columns.count))
        accepted = (*self.accepted, AcceptedEffect(candidate, effect))
        fit = fit_baseline(self.data, baseline, BaselineProducts(self.data, baseline).equations)
        return replace(self, accepted=accepted, baseline=baseline, fit=fit)

    def columns(self, candidate: Candidate, effect: Effect) -> Columns:
        """The columns of a candidate's effect, those of the data where it is one of its options."""
        return columns_beside(self.problem, self.data, self.model, candidate, effect)

    def is_near(self, model: Model) -> bool:
        """Whether candidates' columns by the hypothesis' model serve as well as by another one, to search among them."""
        for before, after in zip(self.problem.referred(self.model), self.problem.referred(model), strict=True):
            for name in ("load", "motor"):
                old, new = before.from_model(name), after.from_model(name)
                apart, size = np.zeros(old.shape[1]), np.zeros(old.shape[1])
                for some in blocks(len(old)):
                    apart += ((new[some] - old[some]) ** 2).sum(axis=0)
                    size += (old[some] ** 2).sum(axis=0)
                if (apart > NEAR**2 * size).any():
                    return False
        return True

    @property
    def residual(self) -> Array:
        """The fit's residual (M, n) [N m|N] without the rows' weights; friction at rest is at its best value in its band."""
        return self.fit.residual / self.problem.weights - self.rest_friction

    @cached_property
    def rest_friction(self) -> Array:
        """What the friction of joints at rest adds (M, n) [N m|N] to the extended model's torque, see ``rest_rows``."""
        rests = rest_rows(self.extension.model, self.problem.signals, self.problem.filter)
        return rests.friction * self.data.regressor.counted

    @property
    def built_up(self) -> set[tuple[str, tuple[int, ...]]]:
        """The laws, by name and joint, to whose level an accepted effect with a memory builds up."""
        memories = [one for one in self.accepted if not one.effect.pointwise and len(one.candidate.joints) == 1]
        robot = self.problem.model.robot
        return {(one.effect.folded(robot, np.ones(1))[0].name, one.candidate.joints) for one in memories}

    def usual_power(self, joint: int) -> float:
        """The squared error, in units of the noise, that a healthy joint (from 1) shows in as many rows; zero where that is not known."""
        problem, j = self.problem, joint - 1
        if problem.usual_error is None:
            return 0.0
        rows = problem.regressor.counted[self.in_folds, j].sum()
        return float(rows * (self.fit.weights[j] * problem.usual_error[j]) ** 2)

    @property
    def torque(self) -> Array:
        """The measured torque (M, n) [N m|N] after the filter."""
        return self.data.regressor.torque / self.problem.weights

    @property
    def in_folds(self) -> NDArray[np.bool_]:
        """Rows (M,) that belong to a fold."""
        return self.data.fold != OUTSIDE


def state_hypothesis(
    problem: DiagnosisProblem, accepted: Sequence[AcceptedEffect], model: Model, data: SearchData | None = None
) -> Hypothesis:
    """The hypothesis of some accepted effects, with columns that depend on a model evaluated by ``model``.

    ``data`` of a model that is near enough is taken as it is, see ``Hypothesis.is_near``.
    """
    data = problem.search_data(model) if data is None else data
    candidates = {c.key: c for c in (*problem.candidates, *(c for c in data.candidates if c.placebo))}
    for key in (*problem.barred, *(one.candidate.key for one in accepted)):
        candidates.pop(key, None)
    contacts = [one.effect for one in accepted if isinstance(one.effect, Contact)]
    data = replace(data, candidates=tuple(candidates.values()), fold=_without_contacts(problem, contacts))
    baseline = problem.baseline(data)
    for one in accepted:
        columns = columns_beside(problem, data, model, one.candidate, one.effect)
        baseline = baseline.joined(columns, prior_precision(one.effect, columns.count))
    return Hypothesis(
        problem=problem,
        accepted=tuple(accepted),
        model=model,
        data=data,
        baseline=baseline,
        fit=fit_baseline(data, baseline, BaselineProducts(data, baseline).equations),
    )


def columns_beside(
    problem: DiagnosisProblem, data: SearchData, model: Model, candidate: Candidate, effect: Effect
) -> Columns:
    """The columns of a candidate's effect beside the ``data`` of a model, which hold them where the effect is an option."""
    known: dict[Effect, Columns] = data.kept.setdefault("columns", {})
    if effect in known:
        return known[effect]
    for option in candidate.options:
        if option.effect == effect and len(option.columns):
            known[effect] = data.columns(option.columns)
            return known[effect]
    return problem.columns(effect, model)


def _without_contacts(problem: DiagnosisProblem, contacts: Sequence[Contact]) -> NDArray[np.intp]:
    """The folds without the rows of contacts, whose force no other fold can predict."""
    fold, margin = problem.fold.copy(), 1 / problem.filter.cutoff
    for contact in contacts:
        fold[rows_during(problem, contact.recording, contact.intervals, margin)] = OUTSIDE
    return fold


def rows_during(
    problem: DiagnosisProblem, recording: str, intervals: Sequence[tuple[float, float]], margin: float = 0.0
) -> NDArray[np.bool_]:
    """Which rows (M,) lie in some intervals [s] of a recording, given by its hash, or within a ``margin`` [s] of them."""
    rows = np.zeros(len(problem.regressor.time), dtype=bool)
    for index, signals in enumerate(problem.signals):
        if signals.recording == recording:
            time = problem.regressor.time - signals.origin
            inside = [(time >= start - margin) & (time <= end + margin) for start, end in intervals]
            rows |= (problem.regressor.recording == index) & np.any(inside, axis=0)
    return rows


def values_move(alone: Hypothesis, beside: Hypothesis) -> bool:
    """Whether some value of the effects of a hypothesis, certain as it seems ``alone``, is another one ``beside`` further effects, or far less
    certain."""
    later = {one.candidate.key: k for k, one in enumerate(beside.accepted)}
    for i, one in enumerate(alone.accepted):
        k = later[one.candidate.key]
        std, whole = alone.standard_errors(i), beside.standard_errors(k)
        moved = np.abs(beside.effect_values[k] - alone.effect_values[i])
        if (np.maximum(moved, whole) > ELSEWHERE * std).any():
            return True
    return False
