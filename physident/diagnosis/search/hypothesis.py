"""What is known beside some accepted effects: their joint fit, and what the extended model then is."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.problem.evidence import OUTSIDE, Baseline, Evidence, Fit, fit
from physident.diagnosis.search.extension import Extension, extend
from physident.diagnosis.statistics.left_out_residuals import Folded
from physident.diagnosis.statistics.normal_equations import inverted
from physident.dynamics.model import Model
from physident.effects.contact import Contact
from physident.effects.effect import Effect

if TYPE_CHECKING:
    from physident.diagnosis.problem.problem import Case

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
