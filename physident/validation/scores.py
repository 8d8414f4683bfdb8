"""Scores on recordings that were not fitted: RMS and relative error per joint, and the gain of one model over another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.recordings.recording import Recording, recording_count
from physident.threads import one_thread
from physident.validation.predictions import Predictions, predict

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Score:
    """How well a model predicts some recordings, after the filter, over their moving part.

    ``rms`` (n,) [N m|N] of the residual over all recordings; ``each`` (R, n) [%] relative error of each recording,
    100 |measured - predicted| / |measured|, and ``relative`` (n,) [%] its mean over the recordings; ``cutoff`` [Hz] of
    the filter; ``share`` of the recordings' duration that was scored.
    """

    joints: tuple[str, ...]
    rms: Array
    relative: Array
    each: Array
    cutoff: float
    share: float
    recordings: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """The score as plain numbers and texts for JSON."""
        return {
            "joints": list(self.joints),
            "rms": self.rms.tolist(),
            "relative_percent": self.relative.tolist(),
            "relative_percent_each": self.each.tolist(),
            "cutoff": self.cutoff,
            "share_scored": self.share,
            "recordings": list(self.recordings),
        }

    def __repr__(self) -> str:
        rows = [
            f"{recording_count(len(self.recordings))}, cutoff {self.cutoff:g} Hz, {100 * self.share:.0f} % of the time scored",
            "joint                        rms [N m]  error %   100 |measured - predicted| / |measured|",
        ]
        rows += [
            f"{j:5d} {name:<22} {rms:9.4g}  {percent:7.2f}"
            for j, (name, rms, percent) in enumerate(zip(self.joints, self.rms, self.relative, strict=True), 1)
        ]
        return "\n".join(rows)


@dataclass(frozen=True, eq=False)
class Gain:
    """Two models' scores on the same recordings; ``reduction`` (n,) [%] of RMS from the first to the second."""

    before: Score
    after: Score

    @property
    def reduction(self) -> Array:
        """By how much the second model's RMS is smaller [%], negative where it is larger."""
        return 100 * (1 - self.after.rms / np.where(self.before.rms > 0, self.before.rms, np.inf))

    def as_dict(self) -> dict[str, Any]:
        """Both scores and the reduction as plain numbers and texts for JSON."""
        return {
            "before": self.before.as_dict(),
            "after": self.after.as_dict(),
            "reduction_percent": self.reduction.tolist(),
        }

    def __repr__(self) -> str:
        b, a = self.before, self.after
        rows = [
            f"{recording_count(len(b.recordings))}, cutoff {b.cutoff:g} Hz, {100 * b.share:.0f} % of the time scored",
            "joint                        rms [N m] before    after  error % before  after  gain of rms %",
        ]
        for j, name in enumerate(b.joints):
            rows.append(
                f"{j + 1:5d} {name:<22} {b.rms[j]:16.4g} {a.rms[j]:8.4g} {b.relative[j]:15.2f} {a.relative[j]:6.2f} {self.reduction[j]:14.1f}"
            )
        total = 100 * (1 - np.linalg.norm(a.rms / b.rms) / np.sqrt(len(b.rms)))
        verdict = (
            "as good as the first" if abs(total) < 0.05 else f"{abs(total):.1f} % {'better' if total > 0 else 'worse'}"
        )
        return "\n".join([*rows, f"verdict: the second model is {verdict} (RMS, every joint alike)"])


@one_thread
def validate(estimate: Estimate, recordings: Sequence[Recording], include_fitted: bool = False) -> Score:
    """Score of a model on recordings, with the model's filter; raises InputError for recordings it was fitted to.

    Currents without gains take the model's drive gains. ``include_fitted`` allows fitted recordings.
    """
    if not recordings:
        raise InputError("no recordings given, expected at least one that the model was not fitted to")
    if not include_fitted:
        _refuse_fitted(estimate, recordings)
    return _score(estimate, recordings, predict(estimate, recordings))


def _score(estimate: Estimate, recordings: Sequence[Recording], predictions: Predictions) -> Score:
    each = np.array([_relative(predictions, predictions.recording == index) for index in range(len(recordings))])
    total = sum(recording.duration for recording in recordings)
    return Score(
        joints=estimate.model.robot.joint_names,
        rms=predictions.rms,
        relative=each.mean(axis=0),
        each=each,
        cutoff=estimate.filter.cutoff,
        share=min(1.0, len(predictions.time) / predictions.rate / total),
        recordings=tuple(recording.source for recording in recordings),
    )


@one_thread
def compare(before: Estimate, after: Estimate, on: Sequence[Recording], include_fitted: bool = False) -> Gain:
    """The gain of one model over another on recordings that neither was fitted to, both through the same filter.

    Raises InputError as ``validate`` does, and for models of different joints or filters.
    """
    if before.filter != after.filter:
        raise InputError(
            f"the models use cutoffs of {before.filter.cutoff:g} and {after.filter.cutoff:g} Hz; expected one filter: identify both with the same --cutoff"
        )
    if before.model.robot.n != after.model.robot.n:
        raise InputError(
            f"the models have {before.model.robot.n} and {after.model.robot.n} joints; expected the same robot"
        )
    if not include_fitted:
        _refuse_fitted(before, on)
        _refuse_fitted(after, on)
    first, second = predict(before, on), predict(after, on)
    common = first.counted & second.counted
    return Gain(_score(before, on, first.restricted(common)), _score(after, on, second.restricted(common)))


def _relative(predictions: Predictions, rows: NDArray[np.bool_]) -> Array:
    size = np.linalg.norm(predictions.measured[rows], axis=0)
    if (size == 0).any():
        joint = int(np.argmin(size)) + 1
        raise InputError(f"joint {joint}: the measured torque is zero throughout; expected a torque to compare with")
    return 100 * np.linalg.norm(predictions.residual[rows], axis=0) / size


def _refuse_fitted(estimate: Estimate, recordings: Sequence[Recording]) -> None:
    fitted = {source.sha256: source.path for source in estimate.sources}
    for recording in recordings:
        if recording.sha256 in fitted:
            raise InputError(
                f"{recording.source}: is a training recording of this model (as {fitted[recording.sha256]}); expected other recordings, or --include-fitted"
            )
