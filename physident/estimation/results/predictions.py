"""What a model predicts of recordings: filtered torque beside the measured one, over the moving part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import build_regressor
from physident.errors import InputError
from physident.estimation.dry_friction.rest import rest_rows
from physident.recordings.signals import Filter, Signals

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Predictions:
    """Filtered torque of recordings over their moving part.

    ``time`` (M,) [s], ``predicted`` and ``measured`` (M, n) [N m|N], ``recording`` (M,) index of each row's recording,
    ``rate`` [Hz] of the rows. Where ``counted`` (M, n) is False, both torques are zero. ``rest_friction`` (M, n) [N m|N] is
    what the friction of joints at rest adds to the prediction at its best value inside its band; ``moving`` (M, n) are the counted rows whose filter window holds no rest
    of that joint; ``rest_outside`` (n,) is the share of the samples at rest that lie beyond the band.
    """

    time: Array
    predicted: Array
    measured: Array
    recording: NDArray[np.intp]
    rate: float
    counted: NDArray[np.bool_]
    rest_friction: Array
    moving: NDArray[np.bool_]
    rest_outside: Array

    @property
    def residual(self) -> Array:
        """Measured minus predicted torque (M, n) [N m|N], with the friction of joints at rest at its best value."""
        return self.measured - self.predicted - self.rest_friction

    @property
    def rms(self) -> Array:
        """Root mean square (n,) [N m|N] of the residual over the counted rows."""
        return np.sqrt((self.residual**2).sum(axis=0) / np.maximum(self.counted.sum(axis=0), 1))

    def restricted(self, counted: NDArray[np.bool_]) -> Predictions:
        """The same predictions with only these rows (M, n) counted."""
        return replace(
            self,
            measured=self.measured * counted,
            predicted=self.predicted * counted,
            rest_friction=self.rest_friction * counted,
            counted=counted,
            moving=self.moving & counted,
        )

    def __repr__(self) -> str:
        rms = ", ".join(f"{value:.3g}" for value in self.rms)
        return f"Predictions: {len(self.time)} rows at {self.rate:g} Hz, RMS of the residual {rms} N m (joint by joint)"


def predictions_of(model: Model, signals: Sequence[Signals], filter: Filter) -> Predictions:
    """The predictions of a model for signals; raises InputError for one that moves for less time than the filter lasts."""
    regressor = build_regressor(model.robot, model.effects, signals, filter, theta=model.theta)
    for index, one in enumerate(signals):
        if not (regressor.recording == index).any():
            raise InputError(f"{one.source}: its moving part is shorter than the filter; expected seconds of motion")
    rests = rest_rows(model, signals, filter)
    return Predictions(
        time=regressor.time,
        predicted=regressor.predict(model.theta),
        rest_friction=rests.friction * regressor.counted,
        measured=regressor.torque,
        recording=regressor.recording,
        rate=regressor.kept_rate,
        counted=regressor.counted,
        moving=rests.moving & regressor.counted,
        rest_outside=rests.outside,
    )
