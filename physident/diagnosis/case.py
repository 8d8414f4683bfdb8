"""A case to diagnose: what stays the same through the search, and the evidence for a set of accepted effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.candidates import Candidate, Option, possible, with_placebos
from physident.diagnosis.evidence import OUTSIDE, Baseline, Evidence, Fit, fit, folds, noise
from physident.diagnosis.extension import Extension, extend
from physident.diagnosis.left_out import Folded
from physident.diagnosis.normal import inverted
from physident.diagnosis.question import Freedom, Question, freedom
from physident.diagnosis.row_noise import row_weights, weighted
from physident.diagnosis.velocity_noise import SignByPosition
from physident.effects import DEFAULT_EFFECTS
from physident.effects.contact import Contact
from physident.effects.effect import Effect
from physident.estimation.estimate import Estimate
from physident.estimation.uncertainty import correlation_rows
from physident.model import Model
from physident.regressor import Regressor, build_regressor
from physident.signals import Filter, Signals

Array = NDArray[np.float64]
NEAR = 0.1  # of a joint's torque: an error of a tenth in a candidate's column costs it a hundredth of its gain


STIFF = 1e-4  # 1/N^2: a force of 100 N is one standard deviation, which keeps a singular pose from inventing more


def precision(effect: Effect) -> float:
    """Prior precision of an accepted effect's values: none, but for the force of a contact."""
    return STIFF if isinstance(effect, Contact) else 0.0


@dataclass(frozen=True)
class Accepted:
    """A candidate that was accepted, and its concrete effect with the shape it was found to have."""

    candidate: Candidate
    effect: Effect


@dataclass(frozen=True, eq=False)
class Case:
    """The question, the model it is put to, the signals, and a regressor of the model's columns and all candidates', its rows
    multiplied by ``weights`` (M, n)."""

    question: Question
    start: Estimate | Model
    signals: tuple[Signals, ...]
    filter: Filter
    seed: int
    regressor: Regressor
    candidates: tuple[Candidate, ...]
    freedom: Freedom
    fold: NDArray[np.intp]
    memory: Array
    weights: Array
    known: dict[tuple[Effect, Model | None], list[Array]] = field(default_factory=dict)  # columns evaluated before

    @property
    def model(self) -> Model:
        """The model as it came."""
        return self.start if isinstance(self.start, Model) else self.start.model

    @cached_property
    def lacking(self) -> tuple[Accepted, ...]:
        """Effects of an ordinary arm that the model does not have."""
        own = {(e.name, j + 1) for e in self.model.effects for j in e.active(self.model.robot)}
        every = [c for c in self.candidates if c.name in DEFAULT_EFFECTS and (c.name, c.joints[0]) not in own]
        return tuple(Accepted(c, c.options[0].effect) for c in every if c.options[0].effect is not None)

    @staticmethod
    def open(
        question: Question, start: Estimate | Model, signals: Sequence[Signals], filter: Filter, seed: int
    ) -> Case:
        """Evaluate every candidate once and choose the folds."""
        model = start if isinstance(start, Model) else start.model
        effects: list[Effect] = list(model.effects)
        at = len(model.columns)
        candidates = []
        for name, joints, shaped in possible(model, signals):
            options = []
            for effect in shaped:
                count = len(effect.columns(model.robot))
                options.append(Option(effect, tuple(range(at, at + count))))
                effects.append(effect)
                at += count
            candidates.append(Candidate(name, joints, tuple(options)))
        blur = SignByPosition()
        nuisance = tuple(range(at, at + len(blur.columns(model.robot))))
        regressor = build_regressor(model.robot, [*effects, blur], signals, filter, model=model)
        case = Case(
            question, start, tuple(signals), filter, seed, regressor, tuple(candidates),
            freedom(start, question, regressor, nuisance), np.zeros(len(regressor.time), dtype=np.intp), np.ones(model.robot.n),
            np.ones(regressor.torque.shape),
        )  # fmt: skip
        weights = row_weights(model, signals, filter, case._noise(model).sigma)
        case = replace(case, weights=weights, regressor=weighted(regressor, weights))
        memory = correlation_rows(regressor, case._noise(model).residual)
        case = replace(case, memory=memory)
        evidence, baseline = case.evidence(model), case.freedom.baseline(case.regressor)
        now = fit(evidence, baseline)
        return replace(case, fold=folds(evidence, baseline, now, float(memory.max()), len(signals), seed))

    def _noise(self, model: Model) -> Fit:
        """What no candidate explains."""
        return noise(self.evidence(model), self.freedom.baseline(self.regressor))

    def evidence(self, model: Model) -> Evidence:
        """Candidates and the torque that the model as it came leaves, columns that depend on a model by ``model``."""
        regressor, placebos = with_placebos(self._referred(model), self.seed)
        theta = np.zeros(len(regressor.columns))
        theta[: len(self.model.theta)] = self.model.theta
        return Evidence(
            regressor,
            (*self.candidates, *placebos),
            regressor.torque - regressor.predict(theta),
            self.fold,
            self.memory,
        )

    def state(self, accepted: Sequence[Accepted], model: Model, evidence: Evidence | None = None) -> State:
        """The evidence beside some accepted effects, with columns that depend on a model by ``model``.

        ``evidence`` of a model that is near enough is taken as it is, see ``State.near``.
        """
        evidence = self.evidence(model) if evidence is None else evidence
        every = {c.key: c for c in (*self.candidates, *(c for c in evidence.candidates if c.placebo))}
        evidence = replace(evidence, candidates=tuple(every.values()))
        taken = {a.candidate.key for a in accepted}
        evidence = replace(evidence, candidates=tuple(c for c in evidence.candidates if c.key not in taken))
        evidence = replace(evidence, fold=self._fold([a.effect for a in accepted if isinstance(a.effect, Contact)]))
        baseline = self.freedom.baseline(evidence.regressor)
        for a in accepted:
            baseline = baseline.joined(self.columns(a.effect, model), precision(a.effect))
        return State(self, tuple(accepted), model, evidence, baseline, fit(evidence, baseline))

    def _fold(self, contacts: Sequence[Contact]) -> NDArray[np.intp]:
        """The folds without the rows of contacts, whose force no other fold can tell."""
        fold = self.fold.copy()
        for contact in contacts:
            for index, signals in enumerate(self.signals):
                rows = (self.regressor.recording == index) & (signals.recording == contact.recording)
                time = self.regressor.time - signals.origin
                for start, end in contact.intervals:
                    fold[rows & (time >= start - 1 / self.filter.cutoff) & (time <= end + 1 / self.filter.cutoff)] = (
                        OUTSIDE
                    )
        return fold

    def columns(self, effect: Effect, model: Model) -> list[Array]:
        """A concrete effect's columns (M, k) in each joint's rows, by a model."""
        key = (effect, model if effect.needs_model else None)
        if key not in self.known:
            self.known[key] = self._evaluated(effect, model)
        return self.known[key]

    def _evaluated(self, effect: Effect, model: Model) -> list[Array]:
        own = build_regressor(model.robot, [effect], self.signals, self.filter, model=model)
        k = len(own.columns)
        result = []
        for j, rows in enumerate(own.joints):
            values = np.zeros((len(own.time), k))
            values[:, rows.columns] = rows.values
            result.append(values * (self.weights * self.regressor.counted)[:, j : j + 1])
        return result

    def _referred(self, model: Model) -> Regressor:
        """The regressor with the columns that depend on a model evaluated by ``model``."""
        if model is self.model:
            return self.regressor
        effects = [*self.model.effects, *(o.effect for c in self.candidates for o in c.options if o.effect is not None)]
        dependent = [effect for effect in effects if effect.needs_model]
        owner = [effect for effect in effects for _ in effect.columns(model.robot)]
        places = np.array([i for i, effect in enumerate(owner) if effect.needs_model], dtype=np.intp)
        fresh = build_regressor(model.robot, dependent, self.signals, self.filter, model=model)
        return self.regressor.with_columns(weighted(fresh, self.weights), places)


@dataclass(frozen=True, eq=False)
class State:
    """The evidence beside accepted effects, their joint fit to all rows, and what the extended model then is."""

    case: Case
    accepted: tuple[Accepted, ...]
    model: Model
    evidence: Evidence
    baseline: Baseline
    fit: Fit

    def sizes(self) -> list[int]:
        """How many columns each accepted effect has."""
        return [len(a.effect.columns(self.case.model.robot)) for a in self.accepted]

    @cached_property
    def folded(self) -> Folded:
        """The same baseline fitted outside each fold."""
        return Folded(self.evidence, self.baseline, self.fit.weights)

    @cached_property
    def extension(self) -> Extension:
        """The model at the values of the joint fit."""
        own = len(self.case.freedom.prior)
        model = self.case.model
        moved = Model(model.robot, model.effects, model.theta + self.case.freedom.map @ self.fit.x[:own])
        changes = np.split(self.fit.x[own:], np.cumsum(self.sizes())[:-1]) if self.accepted else []
        return extend(moved, [a.effect for a in self.accepted], changes)

    @cached_property
    def jacobian(self) -> Array:
        """How the extended model's theta (P,) moves with the values of the joint fit: (P, R)."""
        own = len(self.case.freedom.prior)
        J = np.zeros((len(self.extension.model.theta), len(self.fit.x)))
        J[: len(self.case.model.theta), :own] = self.case.freedom.map
        at = own
        for places in self.extension.places:
            J[places, at + np.arange(len(places))] = 1.0
            at += len(places)
        return J

    @cached_property
    def covariance(self) -> Array:
        """Covariance (P, P) of the extended model's theta where residuals are as independent as their memory says."""
        return self.jacobian @ inverted(self.fit.normal) @ self.jacobian.T

    def also(self, candidate: Candidate, effect: Effect) -> State:
        """The same with one effect more; columns that depend on a model stay as they are."""
        baseline = self.baseline.joined(self.case.columns(effect, self.model), precision(effect))
        accepted = (*self.accepted, Accepted(candidate, effect))
        return State(self.case, accepted, self.model, self.evidence, baseline, fit(self.evidence, baseline))

    def near(self, model: Model) -> bool:
        """Whether candidates' columns by the state's model are as good as by another one, to search among them."""
        for signals in self.case.signals:
            before, after = self.model.refer(signals), model.refer(signals)
            for name in ("load", "motor"):
                old, new = before.from_model(name), after.from_model(name)
                if (np.linalg.norm(new - old, axis=0) > NEAR * np.linalg.norm(old, axis=0)).any():
                    return False
        return True

    @property
    def residual(self) -> Array:
        """The fit's residual (M, n) [N m|N] without the rows' weights."""
        return self.fit.residual / self.case.weights

    @property
    def torque(self) -> Array:
        """The measured torque (M, n) [N m|N] after the filter."""
        return self.evidence.regressor.torque / self.case.weights

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Rows (M,) that belong to a fold."""
        return self.evidence.fold != OUTSIDE
