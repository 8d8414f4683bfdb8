"""An estimate: an identified model with its uncertainty, which is printed, saved and compared."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from physident.dynamics.model import Model
from physident.errors import InputError, did_you_mean
from physident.estimation.estimate_text import estimate_text
from physident.estimation.estimated_model import EstimatedModel
from physident.estimation.estimators import WLS, estimator_as_dict
from physident.estimation.physical.certificate import Certificate
from physident.estimation.results.notebook import estimate_html
from physident.estimation.results.predictions import Predictions, predictions_of
from physident.estimation.results.values import value_figure, value_frame
from physident.files import write_json
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.load import Recordings, as_recordings
from physident.recordings.preparation import prepare
from physident.recordings.signals import Filter
from physident.setup_checks.check_setup import warn_of_setup

SCHEMA = "physident.model/1"


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Estimate(EstimatedModel):
    """An identified model and its uncertainty; see ``EstimatedModel`` for its fields.

    Printing it gives the values with their standard errors and a verdict; ``save`` writes the model file that
    ``load_estimate`` reads.
    """

    def with_cutoff(self, cutoff: float | None) -> Estimate:
        """The estimate with another cutoff [Hz] of its filter; the same estimate where ``cutoff`` is None."""
        return self if cutoff is None else replace(self, filter=replace(self.filter, cutoff=cutoff))

    def __getitem__(self, name: str) -> float:
        """The value of one parameter by its name, such as "viscous_friction_2", in the unit of its column.

        Raises InputError for a name that the model does not have.
        """
        names = [column.name for column in self.model.columns]
        if name not in names:
            end = did_you_mean(name, names)
            raise InputError(f"the model has no parameter {name!r}, expected a name such as {names[-1]!r}{end}")
        return float(self.theta[names.index(name)])

    def predict(self, recordings: Recordings) -> Predictions:
        """Filtered torque (M, n) [N m|N] that the model predicts, beside the measured one, for one or several recordings.

        Recordings may be paths or patterns, whose files are read with the model's layout. Currents without drive gains take
        those of the model. Raises InputError for a recording of another number of joints, and for one that moves for less
        time than the filter lasts.
        """
        robot, signals = self.model.robot, []
        given = as_recordings(recordings, robot, self.layout)
        warn_of_setup(None, given)
        for recording in given:
            if recording.n != robot.n:
                raise InputError(f"{recording.source}: {recording.n} joints, but robot {robot.name} has {robot.n}")
            signals.append(prepare(recording.with_default_drive_gains(self.drive_gains), self.filter))
        if not signals:
            raise InputError("no recordings given, expected at least one")
        return predictions_of(self.model, signals, self.filter)

    def to_frame(self) -> Any:
        """The parameters as a pandas frame: joint, effect, value, unit, standard error, 95 % interval."""
        return value_frame(self)

    def plot(self) -> Any:
        """A matplotlib figure of the parameters that are identified one by one, with their 95 % intervals."""
        return value_figure(self)

    def save(self, path: str | Path) -> None:
        """Write the estimate as JSON (schema physident.model/1), whole or not at all."""
        write_json(path, self.as_dict())

    def as_dict(self) -> dict[str, Any]:
        """The whole estimate as plain numbers, texts and lists for JSON."""
        return {
            "schema": SCHEMA,
            **self.model.as_dict(),
            "estimator": estimator_as_dict(self.estimator),
            "prior_weight": self.prior_weight,
            "blocks": self.blocks,
            "shares": list(self.shares),
            "base_shares": list(self.base_shares),
            "held": list(self.active_constraints),
            "shapes": [vars(shape) for shape in self.shape_parameters],
            "violations": list(self.violations),
            "unsized": list(self.unsized),
            "warnings": list(self.warnings),
            "base_parameters": self._base_parameters(),
            "covariance": self.covariance.tolist(),
            "information": None if self.information is None else self.information.tolist(),
            "sigma": self.sigma.tolist(),
            "relative_percent": self.relative.tolist(),
            "effective_samples": self.effective_samples.tolist(),
            "certificate": vars(self.certificate),
            "filter": vars(self.filter),
            "columns": self.layout,
            "drive_gains": self.drive_gains and list(self.drive_gains),
            "recordings": [vars(source) for source in self.sources],
        }

    def _base_parameters(self) -> list[dict[str, Any]]:
        rows = zip(
            self.base.expressions(), self.base.values(self.theta), np.sqrt(np.diag(self.covariance)), strict=True
        )
        return [{"expression": text, "value": float(value), "std": float(std)} for text, value, std in rows]

    def __repr__(self) -> str:
        return estimate_text(self)

    def _repr_html_(self) -> str:
        return estimate_html(self, estimate_text(self))


def as_estimate(model: Estimate | Model, filter: Filter) -> Estimate:
    """An estimate without known uncertainty, made of a model's values; an estimate is returned as it is."""
    if isinstance(model, Estimate):
        return model
    r, n = find_base_parameters(model.robot, model.effects).r, model.robot.n
    return Estimate(
        model=model,
        estimator=WLS(),
        covariance=np.zeros((r, r)),
        sigma=np.zeros(n),
        relative=np.zeros(n),
        effective_samples=np.zeros(n),
        certificate=Certificate(stationarity=0.0, condition=1.0, determined=0, iterations=0),
        filter=filter,
        sources=(),
        base_shares=(0.0,) * r,
    )
