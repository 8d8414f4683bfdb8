"""What a model predicts of recordings: filtered torque beside the measured one, over the moving part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import build_regressor
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.recordings.recording import Recording
from physident.validation.rest import rest_rows

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Predictions:
    """Filtered torque of recordings over their moving part.

    ``time`` (M,) [s], ``predicted`` and ``measured`` (M, n) [N m|N], ``recording`` (M,) index of each row's recording,
    ``rate`` [Hz] of the rows. Where ``counted`` (M, n) is False, both torques are zero. ``predicted`` includes the friction of
    joints at rest at its best value inside its band; ``moving`` (M, n) are the counted rows whose filter window holds no rest
    of that joint; ``rest_outside`` (n,) is the share of the samples at rest that lie beyond the band.
    """

    time: Array
    predicted: Array
    measured: Array
    recording: NDArray[np.intp]
    rate: float
    counted: NDArray[np.bool_]
    moving: NDArray[np.bool_]
    rest_outside: Array

    @property
    def residual(self) -> Array:
        """Measured minus predicted torque (M, n) [N m|N]."""
        return self.measured - self.predicted

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
            counted=counted,
            moving=self.moving & counted,
        )


def predict(estimate: Estimate, recordings: Sequence[Recording]) -> Predictions:
    """The predictions of a model for recordings, through the model's filter.

    Currents without drive gains take those of the model. Raises InputError for recordings that do not fit the robot,
    and for one that moves for less time than the filter lasts.
    """
    model = estimate.model
    converted = [recording.with_default_drive_gains(estimate.drive_gains) for recording in recordings]
    signals = prepare_all(model.robot, converted, estimate.filter)
    regressor = build_regressor(model.robot, model.effects, signals, estimate.filter, theta=model.theta)
    for index, one in enumerate(signals):
        if not (regressor.recording == index).any():
            raise InputError(f"{one.source}: its moving part is shorter than the filter; expected seconds of motion")
    rests = rest_rows(model, signals, estimate.filter)
    return Predictions(
        time=regressor.time,
        predicted=regressor.predict(model.theta) + rests.friction * regressor.counted,
        measured=regressor.torque,
        recording=regressor.recording,
        rate=regressor.kept_rate,
        counted=regressor.counted,
        moving=rests.moving & regressor.counted,
        rest_outside=rests.outside,
    )
