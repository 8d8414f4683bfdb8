"""Scores on recordings that were not fitted: RMS and relative error per joint, and the gain of one model over another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import build_regressor
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.estimation.estimate_text import counted
from physident.estimation.identify import prepare_all
from physident.recordings.recording import Recording

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Score:
    """How well a model predicts some recordings, after the filter, over their moving part.

    ``rms`` (n,) [N m|N] over all of them; ``relative`` (n,) [%] 100 |measured - predicted| / |measured|, the mean over
    recordings; ``each`` (R, n) [%] that of each; ``share`` of the recordings' duration that was scored.
    """

    joints: tuple[str, ...]
    rms: Array
    relative: Array
    each: Array
    cutoff: float
    share: float
    recordings: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """The score as JSON can hold it."""
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
            f"{counted(len(self.recordings))}, cutoff {self.cutoff:g} Hz, {100 * self.share:.0f} % of the time scored",
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
        """Both scores and the reduction, as JSON can hold them."""
        return {
            "before": self.before.as_dict(),
            "after": self.after.as_dict(),
            "reduction_percent": self.reduction.tolist(),
        }

    def __repr__(self) -> str:
        b, a = self.before, self.after
        rows = [
            f"{counted(len(b.recordings))}, cutoff {b.cutoff:g} Hz, {100 * b.share:.0f} % of the time scored",
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


def validate(estimate: Estimate, recordings: Sequence[Recording], include_fitted: bool = False) -> Score:
    """Score of a model on recordings, with the model's own filter; raises InputError for recordings it was fitted to.

    Currents without gains take the model's drive gains. ``include_fitted`` allows fitted recordings.
    """
    if not recordings:
        raise InputError("no recordings given, expected at least one that was not fitted")
    if not include_fitted:
        _refuse_fitted(estimate, recordings)
    return _score(estimate, recordings, predictions(estimate, recordings))


def _score(estimate: Estimate, recordings: Sequence[Recording], p: Predictions) -> Score:
    each = np.array([_relative(p, p.recording == index) for index in range(len(recordings))])
    total = sum(recording.duration for recording in recordings)
    return Score(
        joints=estimate.model.robot.joint_names,
        rms=np.sqrt(((p.measured - p.predicted) ** 2).sum(axis=0) / p.counted.sum(axis=0)),
        relative=each.mean(axis=0),
        each=each,
        cutoff=estimate.filter.cutoff,
        share=min(1.0, len(p.time) / p.rate / total),
        recordings=tuple(recording.source for recording in recordings),
    )


def compare(before: Estimate, after: Estimate, on: Sequence[Recording], include_fitted: bool = False) -> Gain:
    """The gain of one model over another on recordings neither was fitted to, both through the first one's filter.

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
    first, second = predictions(before, on), predictions(after, on)
    common = first.counted & second.counted  # both are judged on the same rows
    return Gain(_score(before, on, _only(first, common)), _score(after, on, _only(second, common)))


def _only(p: Predictions, counted: NDArray[np.bool_]) -> Predictions:
    """The same predictions with fewer rows counted."""
    return replace(p, measured=p.measured * counted, predicted=p.predicted * counted, counted=counted)


@dataclass(frozen=True, eq=False)
class Predictions:
    """Filtered torque of recordings over their moving part: ``time`` (M,) [s], ``predicted`` and ``measured`` (M, n)
    [N m|N], ``recording`` (M,) the index of each row's recording, ``rate`` [Hz] of the rows; a row of a joint that is not
    ``counted`` (M, n) is zero on both sides."""

    time: Array
    predicted: Array
    measured: Array
    recording: NDArray[np.intp]
    rate: float
    counted: NDArray[np.bool_]


def predictions(estimate: Estimate, recordings: Sequence[Recording]) -> Predictions:
    """What a model predicts of recordings, through its own filter; currents without gains take the model's."""
    model = estimate.model
    gained = [with_gains(recording, estimate.drive_gains) for recording in recordings]
    signals = prepare_all(model.robot, gained, estimate.filter)
    regressor = build_regressor(model.robot, model.effects, signals, estimate.filter, theta=model.theta)
    for index, one in enumerate(signals):
        if not (regressor.recording == index).any():
            raise InputError(f"{one.source}: its moving part is shorter than the filter; expected seconds of motion")
    return Predictions(
        time=regressor.time,
        predicted=regressor.predict(model.theta),
        measured=regressor.torque,
        recording=regressor.recording,
        rate=regressor.kept_rate,
        counted=regressor.counted,
    )


def with_cutoff(estimate: Estimate, cutoff: float | None) -> Estimate:
    """The estimate with another cutoff [Hz] of its filter; the same where ``cutoff`` is None."""
    return estimate if cutoff is None else replace(estimate, filter=replace(estimate.filter, cutoff=cutoff))


def with_gains(recording: Recording, gains: tuple[float, ...] | None) -> Recording:
    """The recording with a model's drive gains, where it holds currents and has none of its own."""
    if recording.effort_kind == "current" and recording.drive_gains is None and gains is not None:
        return recording.with_drive_gains(gains)
    return recording


def _relative(p: Predictions, rows: NDArray[np.bool_]) -> Array:
    size = np.linalg.norm(p.measured[rows], axis=0)
    if (size == 0).any():
        joint = int(np.argmin(size)) + 1
        raise InputError(f"joint {joint}: the measured torque is zero throughout; expected a torque to compare with")
    return 100 * np.linalg.norm((p.measured - p.predicted)[rows], axis=0) / size


def _refuse_fitted(estimate: Estimate, recordings: Sequence[Recording]) -> None:
    fitted = {source.sha256: source.path for source in estimate.sources}
    for recording in recordings:
        if recording.sha256 in fitted:
            raise InputError(
                f"{recording.source}: was fitted by this model (as {fitted[recording.sha256]}); expected recordings it never saw, or --include-fitted"
            )
