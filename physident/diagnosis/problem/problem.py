"""The problem of a diagnosis: everything that does not change during the search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.baseline_fit import fit_baseline, fit_with_all_candidates
from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate, laid_out, with_placebos
from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.problem.effect_columns import effect_columns
from physident.diagnosis.problem.folds import split_into_folds
from physident.diagnosis.problem.ordinary_model import ordinary_model
from physident.diagnosis.problem.question import ParameterFreedom, Question, parameter_freedom
from physident.diagnosis.problem.recording_offset import offset_of_each_recording
from physident.diagnosis.problem.resolution import at_resolution
from physident.diagnosis.problem.search_data import Baseline, SearchData, tool_jacobians
from physident.diagnosis.repeated.comparison import Comparison
from physident.diagnosis.repeated.sureness import as_sure_as
from physident.dynamics.column_structure import KeptRows, kept_rows
from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor, with_transition
from physident.effects.catalogue import DEFAULT_EFFECTS
from physident.effects.classification import Family
from physident.effects.effect import Effect
from physident.estimation.dry_friction.row_weights import dry_level, known_rows, rest_weights, spread_rows
from physident.estimation.estimate import Estimate
from physident.estimation.uncertainty import correlation_rows
from physident.estimation.weighting import weight_rows
from physident.large_arrays import magnitude
from physident.recordings.signals import MOVING_SPEED, Filter, Signals

Array = NDArray[np.float64]
KEPT = 1 << 27  # bytes of the columns of effects that were tried
MODELS = 3  # whose signals are kept: the one given, the last one, and the one that may follow it


@dataclass(frozen=True, kw_only=True, eq=False)
class DiagnosisProblem:
    """The question, the model it is asked about, the signals, and a regressor of the model's and all candidates' columns.

    ``given`` is the model as it came. Rows of ``regressor`` are multiplied by ``weights`` (M, n); ``fold`` (M,) says which
    rows are left out together, ``memory`` (n,) how many correlated rows are worth one. ``recording_offsets``: whether each
    recording has a constant torque that is refitted and never named. ``barred`` candidates, by name and joints, are not searched.
    ``usual_error`` (n,) [N m|N]: the RMS error on new recordings that nine of ten healthy joints do not exceed; None if not known, or taken off.
    """

    question: Question
    given: Estimate | Model
    signals: tuple[Signals, ...]
    filter: Filter
    seed: int
    regressor: Regressor
    candidates: tuple[Candidate, ...]
    placebos: tuple[Candidate, ...] = ()
    freedom: ParameterFreedom
    fold: NDArray[np.intp]
    memory: Array
    weights: Array
    recording_offsets: bool = False
    usual_error: Array | None = None
    barred: frozenset[tuple[str, tuple[int, ...]]] = frozenset()
    evaluated: dict[tuple[Effect, Model | None], Columns] = field(default_factory=dict)  # the latest columns, once each
    by_model: list[tuple[Model, list[Signals]]] = field(default_factory=list)  # signals as the latest models see them

    @property
    def model(self) -> Model:
        """The model as given."""
        return self.given if isinstance(self.given, Model) else self.given.model

    @property
    def all_compared(self) -> bool:
        """Whether every recording repeats one of the control, whose error was taken off."""
        return len(self.freedom.compared) == len(self.signals)

    @cached_property
    def taken_off_squares(self) -> Array:
        """The squared error (n,) [(N m|N)^2] of the model that was taken off all compared rows, as large as it usually is: a change
        is of use beside it, and not beside the noise that a comparison leaves."""
        if not isinstance(self.given, Estimate):
            return np.zeros(self.model.robot.n)
        rows = np.isin(self.regressor.recording, sorted(self.freedom.compared))
        return self.given.sigma**2 * np.sum(self.scale[rows] ** 2, axis=0)

    @cached_property
    def torque_noise(self) -> Array:
        """What the filter passes (n,) [N m|N] of the torque signals' own white noise."""
        gains = [float(np.sqrt(np.sum(self.filter.taps(one.rate) ** 2))) for one in self.signals]
        return np.mean([gain * one.torque_noise for gain, one in zip(gains, self.signals, strict=True)], axis=0)

    @cached_property
    def resting_joints(self) -> frozenset[int]:
        """Joints (from 1) that no recording moves: what their velocity shows is noise."""
        fastest = np.max([magnitude(one.v) for one in self.signals], axis=0)
        return frozenset(int(j) + 1 for j in np.flatnonzero(fastest < MOVING_SPEED * self.model.robot.radian))

    def is_friction_of_resting_joint(self, candidate: Candidate) -> bool:
        """Whether a candidate is the friction of a joint that no recording moves, or of an arm that none moves."""
        effect = candidate.options[0].effect
        is_friction = effect is not None and effect.family is Family.FRICTION
        return is_friction and self.resting_joints.issuperset(candidate.joints or range(1, self.model.robot.n + 1))

    @cached_property
    def present(self) -> frozenset[tuple[str, tuple[int, ...]]]:
        """The effects that the model has, by their name and the joint (from 1) they act on."""
        return frozenset((e.name, (j + 1,)) for e in self.model.effects for j in e.active(self.model.robot))

    @cached_property
    def missing_default_effects(self) -> tuple[AcceptedEffect, ...]:
        """Default effects, such as friction, that the model does not have."""
        return tuple(
            AcceptedEffect(c, c.options[0].effect)
            for c in self.candidates
            if c.name in DEFAULT_EFFECTS
            and c.key not in self.present
            and not self.is_friction_of_resting_joint(c)
            and c.options[0].effect is not None
        )

    def search_data(self, model: Model) -> SearchData:
        """The candidates' columns, those that depend on a model evaluated by ``model``, and the torque to explain."""
        regressor = self._evaluated_by(model)
        theta = np.zeros(len(regressor.columns))
        theta[: len(self.model.theta)] = self.model.theta
        return SearchData(
            regressor=regressor,
            candidates=(*self.candidates, *self.placebos),
            response=regressor.residual(theta),
            fold=self.fold,
            memory=self.memory,
            model_columns=len(self.model.theta),
        )

    def baseline(self, data: SearchData) -> Baseline:
        """The columns of the model that are refitted, computed once for some data."""
        known = data.kept.get("baseline")
        if known is None or known[0] is not self.freedom:
            known = data.kept["baseline"] = (self.freedom, self.freedom.baseline(data.regressor))
        return known[1]

    def columns(self, effect: Effect, model: Model) -> Columns:
        """A concrete effect's columns (M, k) in each joint's rows, evaluated by a model; the latest are kept for the next time."""
        key = (effect, model if effect.needs_model else None)
        if key not in self.evaluated:
            self.evaluated[key] = self.fresh_columns(effect, model)
            while sum(one.size for one in self.evaluated.values()) > KEPT and len(self.evaluated) > 1:
                del self.evaluated[next(iter(self.evaluated))]
        return self.evaluated[key]

    def fresh_columns(self, effect: Effect, model: Model) -> Columns:
        """The same for an effect that is tried once."""
        signals = self.referred(model) if effect.needs_model else self.signals
        return effect_columns(model.robot, effect, signals, self.kept_rows, self.filter, self.scale)

    def forget(self) -> None:
        """Give back the columns that were evaluated for effects that were tried, where another problem takes this one's place."""
        self.evaluated.clear()
        del self.by_model[:]

    @cached_property
    def scale(self) -> Array:
        """By what an effect's rows (M, n) are multiplied: their weights, zero where they are not counted."""
        return self.weights * self.regressor.counted

    @cached_property
    def kept_rows(self) -> list[list[KeptRows]]:
        """The rows of each segment of each recording."""
        return [kept_rows(self.model.robot, one, self.filter, moving_only=True) for one in self.signals]

    @cached_property
    def jacobians(self) -> Array:
        """The Jacobian (M, 3, n) of the tool in each row, as a contact's columns are weighted."""
        return tool_jacobians(self.model.robot, self.regressor, self.signals) * self.scale[:, None, :]

    def referred(self, model: Model) -> list[Signals]:
        """The signals with the torques that a model predicts for them; those of the latest models are kept."""
        for known, signals in self.by_model:
            if known is model:
                return signals
        self.by_model.append((model, [model.refer(one) for one in self.signals]))
        del self.by_model[:-MODELS]
        return self.by_model[-1][1]

    def _evaluated_by(self, model: Model) -> Regressor:
        """The regressor with the columns that depend on a model evaluated by ``model``."""
        if model is self.model:
            return self.regressor
        owned = [(effect, effect.columns(model.robot)) for effect in self.model.effects]
        ends = np.cumsum([0, *(len(columns) for _, columns in owned)])
        placed = [(effect, range(a, b)) for (effect, _), a, b in zip(owned, ends, ends[1:], strict=False)]
        placed += [(o.effect, o.columns) for c in self.candidates for o in c.options if o.effect is not None]
        dependent = [effect for effect, _ in placed if effect.needs_model]
        places = np.array([at for effect, columns in placed if effect.needs_model for at in columns], dtype=np.intp)
        fresh = build_regressor(model.robot, dependent, self.referred(model), self.filter)
        return self.regressor.with_columns(weight_rows(fresh, self.weights), places)


def state_problem(
    question: Question,
    given: Estimate | Model,
    signals: Sequence[Signals],
    filter: Filter,
    seed: int,
    recording_offsets: bool = False,
    comparison: Comparison | None = None,
    usual_error: Array | None = None,
) -> DiagnosisProblem:
    """Evaluate every candidate once, weigh the rows and choose the folds.

    ``signals`` may be those of a ``comparison``: the model's parameters have no part in recordings from which its error was taken.
    """
    model = given if isinstance(given, Model) else given.model
    ordinary = ordinary_model(model, signals, filter)
    signals = [with_transition(model.robot, ordinary.effects, one) for one in signals]
    candidates, effects = laid_out(model, signals)
    nuisances = offset_of_each_recording(signals) if recording_offsets else []
    first = sum(len(effect.columns(model.robot)) for effect in effects)
    nuisance = tuple(range(first, first + sum(len(one.columns(model.robot)) for one in nuisances)))
    regressor = build_regressor(model.robot, [*effects, *nuisances], signals, filter, model=model)
    problem = DiagnosisProblem(
        question=question,
        given=given,
        signals=tuple(signals),
        filter=filter,
        seed=seed,
        regressor=regressor,
        candidates=candidates,
        freedom=parameter_freedom(
            given, question, regressor, nuisance, comparison.compared if comparison else frozenset()
        ),
        fold=np.zeros(len(regressor.time), dtype=np.intp),
        memory=np.ones(model.robot.n),
        weights=np.ones(regressor.torque.shape),
        recording_offsets=recording_offsets,
        usual_error=None if comparison and comparison.compared else usual_error,
    )
    spread = spread_rows(model.robot, ordinary.effects, signals, filter)
    if comparison:
        spread = comparison.spread_of_both(spread, model, ordinary.effects, filter, regressor)
    problem, noise = _weighted(problem, model, spread, dry_level(ordinary))
    size = np.sqrt((noise**2).sum(axis=0) / (problem.weights**2).sum(axis=0))
    if (noisy := at_resolution(signals, regressor, size, filter, seed)) is not None:
        regressor = build_regressor(model.robot, [*effects, *nuisances], noisy, filter, model=model)
        problem = replace(problem, signals=tuple(noisy), regressor=regressor, evaluated={}, by_model=[])
        problem, noise = _weighted(problem, model, spread, dry_level(ordinary))
    problem = replace(problem, memory=correlation_rows(regressor, noise))
    if comparison and 0 < len(comparison.compared) < len(signals):
        surest = comparison.of_compared()
        alone = state_problem(question, given, surest.signals, filter, seed, recording_offsets, surest)
        problem = _beside(problem, regressor, alone)
    return with_memory(problem, problem.memory)


def with_memory(problem: DiagnosisProblem, memory: Array) -> DiagnosisProblem:
    """The problem whose noise remembers other numbers of rows (n,), with folds that are as long as that asks."""
    problem = replace(problem, memory=memory)
    data = problem.search_data(problem.model)
    # with an offset of its own, no recording can be predicted by the others
    recordings = 1 if problem.recording_offsets else len(problem.signals)
    baseline = problem.baseline(data)
    fit = fit_baseline(data, baseline)
    return replace(problem, fold=split_into_folds(data, baseline, fit, float(memory.max()), recordings, problem.seed))


def _weighted(problem: DiagnosisProblem, model: Model, spread: Array, dry: Array) -> tuple[DiagnosisProblem, Array]:
    """The problem with its rows weighted by how well they know the sign of velocity, ``spread`` (M, n), at a ``dry`` friction
    (n,) [N m|N]; and what all candidates at once leave (M, n) of these rows."""
    known = known_rows(spread)
    plain = replace(problem, weights=known, regressor=weight_rows(problem.regressor, known), evaluated={}, by_model=[])
    left = _left_by_all(plain, model)
    weighted = _with_weights(problem, rest_weights(spread, dry, left / known, problem.regressor))
    return weighted, _left_by_all(weighted, model)


def _beside(problem: DiagnosisProblem, unweighted: Regressor, surest: DiagnosisProblem) -> DiagnosisProblem:
    """The problem with the weights and the memory that its compared recordings have alone, and other rows as sure as they are."""
    model = problem.model
    rows = np.isin(problem.regressor.recording, sorted(problem.freedom.compared))
    noise = _left_by_all(surest, model)
    size = np.sqrt((noise**2).sum(axis=0) / np.maximum((surest.weights**2).sum(axis=0), 1e-300))
    left = problem.search_data(model).response * ~rows[:, None]
    weights = problem.weights * as_sure_as(size * np.sqrt(surest.memory), left, problem.weights, problem.regressor)
    weights[rows] = surest.weights
    return replace(_with_weights(replace(problem, regressor=unweighted), weights), memory=surest.memory)


def _with_weights(problem: DiagnosisProblem, weights: Array) -> DiagnosisProblem:
    regressor, placebos = with_placebos(weight_rows(problem.regressor, weights), problem.seed)
    return replace(problem, weights=weights, regressor=regressor, placebos=placebos, evaluated={}, by_model=[])


def _left_by_all(problem: DiagnosisProblem, model: Model) -> Array:
    data = problem.search_data(model)
    return fit_with_all_candidates(data, problem.baseline(data)).residual
