"""What a model predicts of recordings: filtered torque beside the measured one, over the moving part."""

from __future__ import annotations

from collections.abc import Sequence

from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.estimation.results.predictions import Predictions, predictions_of
from physident.recordings.recording import Recording


def predict(estimate: Estimate, recordings: Sequence[Recording]) -> Predictions:
    """The predictions of a model for recordings, through the model's filter.

    Currents without drive gains take those of the model. Raises InputError for recordings that do not fit the robot,
    and for one that moves for less time than the filter lasts.
    """
    converted = [recording.with_default_drive_gains(estimate.drive_gains) for recording in recordings]
    return predictions_of(
        estimate.model, prepare_all(estimate.model.robot, converted, estimate.filter), estimate.filter
    )
