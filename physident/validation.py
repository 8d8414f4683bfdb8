"""Scores on recordings that were not fitted: RMS and relative error per joint, and the gain of one model over another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.recording import Recording
from physident.regressor import build_regressor

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
            f"{len(self.recordings)} recordings, cutoff {self.cutoff:g} Hz, {100 * self.share:.0f} % of their time scored",
            "joint                        rms [N m]  error %",
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

    def __repr__(self) -> str:
        b, a = self.before, self.after
        rows = [
            f"{len(b.recordings)} recordings, cutoff {b.cutoff:g} Hz, {100 * b.share:.0f} % of their time scored",
            "joint                        rms before  after [N m]  error % before  after  gain %",
        ]
        for j, name in enumerate(b.joints):
            rows.append(
                f"{j + 1:5d} {name:<22} {b.rms[j]:11.4g} {a.rms[j]:12.4g} {b.relative[j]:15.2f} {a.relative[j]:6.2f} {self.reduction[j]:7.1f}"
            )
        total = 100 * (1 - np.linalg.norm(a.rms / b.rms) / np.sqrt(len(b.rms)))
        return "\n".join(
            [
                *rows,
                f"verdict: the second model is {abs(total):.1f} % {'better' if total > 0 else 'worse'} (RMS, every joint alike)",
            ]
        )


def validate(estimate: Estimate, recordings: Sequence[Recording], include_fitted: bool = False) -> Score:
    """Score of a model on recordings, with the model's own filter; raises InputError for recordings it was fitted to.

    Currents without gains take the model's drive gains. ``include_fitted`` allows fitted recordings.
    """
    if not recordings:
        raise InputError("no recordings given, expected at least one that was not fitted")
    if not include_fitted:
        _refuse_fitted(estimate, recordings)
    _, predicted, measured, origin, rate = predictions(estimate, recordings)
    each = np.array([_relative(measured[origin == i], predicted[origin == i]) for i in range(len(recordings))])
    total = sum(recording.duration for recording in recordings)
    return Score(
        estimate.model.robot.joint_names,
        np.sqrt(((measured - predicted) ** 2).mean(axis=0)),
        each.mean(axis=0), each, estimate.filter.cutoff, min(1.0, len(measured) / rate / total),
        tuple(recording.source for recording in recordings),
    )  # fmt: skip


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
    return Gain(validate(before, on, include_fitted), validate(after, on, include_fitted))


def predictions(
    estimate: Estimate, recordings: Sequence[Recording]
) -> tuple[Array, Array, Array, NDArray[np.intp], float]:
    """Time (M,), predicted and measured torque (M, n), index of the recording (M,), and the kept rate [Hz]."""
    gained = [with_gains(recording, estimate.drive_gains) for recording in recordings]
    model = estimate.model
    signals = prepare_all(model.robot, gained, estimate.filter)
    for one in signals:  # each must be scored, or a mean over recordings would hide the one that is missing
        build_regressor(model.robot, model.effects[-1:], [one], estimate.filter)
    regressor = build_regressor(model.robot, model.effects, signals, estimate.filter)
    return regressor.time, regressor.predict(model.theta), regressor.torque, regressor.recording, regressor.kept_rate


def with_gains(recording: Recording, gains: tuple[float, ...] | None) -> Recording:
    """The recording with a model's drive gains, where it holds currents and has none of its own."""
    if recording.effort_kind == "current" and recording.drive_gains is None and gains is not None:
        return recording.with_drive_gains(gains)
    return recording


def _relative(measured: Array, predicted: Array) -> Array:
    size = np.linalg.norm(measured, axis=0)
    return 100 * np.linalg.norm(measured - predicted, axis=0) / np.where(size > 0, size, np.nan)


def _refuse_fitted(estimate: Estimate, recordings: Sequence[Recording]) -> None:
    fitted = {source.sha256: source.path for source in estimate.sources}
    for recording in recordings:
        if recording.sha256 in fitted:
            raise InputError(
                f"{recording.source}: was fitted by this model (as {fitted[recording.sha256]}); expected recordings it never saw, or --include-fitted"
            )
