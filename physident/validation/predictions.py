"""What a model predicts of recordings: filtered torque beside the measured one, over the moving part."""

from __future__ import annotations

from collections.abc import Sequence

from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.estimation.results.predictions import Predictions, predictions_of
from physident.recordings.load import Recordings, as_recordings
from physident.recordings.recording import Recording
from physident.setup_checks.check_setup import warn_of_setup


def predict(estimate: Estimate, recordings: Recordings) -> Predictions:
    """The predictions of a model for one or several recordings, paths or patterns, through the model's filter.

    Currents without drive gains take those of the model. Raises InputError for recordings that do not fit the robot,
    and for one that moves for less time than the filter lasts.
    """
    given = as_recordings(recordings, estimate.model.robot, estimate.layout)
    warn_of_setup(None, given)
    return predicted(estimate, given)


def predicted(estimate: Estimate, recordings: Sequence[Recording]) -> Predictions:
    """``predict`` without a word on the set-up, for a caller that has checked it."""
    robot = estimate.model.robot
    converted = [recording.with_default_drive_gains(estimate.drive_gains) for recording in recordings]
    return predictions_of(estimate.model, prepare_all(robot, converted, estimate.filter), estimate.filter)
