"""A case to diagnose: what stays the same through the search, and the evidence for a set of accepted effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import Candidate, Option, possible, with_placebos
from physident.diagnosis.problem.evidence import OUTSIDE, Evidence, Fit, fit, folds, noise
from physident.diagnosis.problem.question import Freedom, Question, freedom
from physident.diagnosis.problem.recording_offset import drifts
from physident.diagnosis.problem.row_noise import row_weights, weighted
from physident.diagnosis.problem.sign_nuisance import SignByPosition
from physident.diagnosis.search.hypothesis import Accepted, State, precision
from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor
from physident.effects.catalogue import DEFAULT_EFFECTS
from physident.effects.classification import Family
from physident.effects.contact import Contact
from physident.effects.effect import Effect
from physident.estimation.estimate import Estimate
from physident.estimation.uncertainty import correlation_rows
from physident.recordings.signals import MOVING_SPEED, Filter, Signals

Array = NDArray[np.float64]


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
    recording_offsets: bool = False
    known: dict[tuple[Effect, Model | None], list[Array]] = field(default_factory=dict)  # columns evaluated before

    @property
    def model(self) -> Model:
        """The model as it came."""
        return self.start if isinstance(self.start, Model) else self.start.model

    @cached_property
    def still(self) -> frozenset[int]:
        """Joints (from 1) that no recording moves: what their velocity shows is noise."""
        fastest = np.max([np.abs(one.v).max(axis=0) for one in self.signals], axis=0)
        return frozenset(int(j) + 1 for j in np.flatnonzero(fastest < MOVING_SPEED))

    def motionless(self, candidate: Candidate) -> bool:
        """Whether a candidate is the friction of a joint that no recording moves."""
        effect = candidate.options[0].effect
        friction = effect is not None and effect.family is Family.FRICTION
        return friction and self.still.issuperset(candidate.joints)

    @cached_property
    def lacking(self) -> tuple[Accepted, ...]:
        """Effects of an ordinary arm that the model does not have."""
        own = {(e.name, j + 1) for e in self.model.effects for j in e.active(self.model.robot)}
        every = [c for c in self.candidates if c.name in DEFAULT_EFFECTS and (c.name, c.joints[0]) not in own]
        every = [c for c in every if not self.motionless(c)]
        return tuple(Accepted(c, c.options[0].effect) for c in every if c.options[0].effect is not None)

    @staticmethod
    def open(
        question: Question,
        start: Estimate | Model,
        signals: Sequence[Signals],
        filter: Filter,
        seed: int,
        recording_offsets: bool = False,
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
        beside = [SignByPosition(), *(drifts(signals) if recording_offsets else [])]
        nuisance = tuple(range(at, at + sum(len(own.columns(model.robot)) for own in beside)))
        regressor = build_regressor(model.robot, [*effects, *beside], signals, filter, model=model)
        case = Case(
            question, start, tuple(signals), filter, seed, regressor, tuple(candidates),
            freedom(start, question, regressor, nuisance), np.zeros(len(regressor.time), dtype=np.intp), np.ones(model.robot.n),
            np.ones(regressor.torque.shape), recording_offsets,
        )  # fmt: skip
        weights = row_weights(model, signals, filter, case._noise(model).sigma)
        case = replace(case, weights=weights, regressor=weighted(regressor, weights))
        memory = correlation_rows(regressor, case._noise(model).residual)
        case = replace(case, memory=memory)
        evidence, baseline = case.evidence(model), case.freedom.baseline(case.regressor)
        now = fit(evidence, baseline)
        known = 1 if recording_offsets else len(signals)  # an offset of a recording's own cannot be told by the others
        return replace(case, fold=folds(evidence, baseline, now, float(memory.max()), known, seed))

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
