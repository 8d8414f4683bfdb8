"""Scores on recordings that were not fitted: RMS and relative error per joint, and the gain of one model over another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.notebook import results_html
from physident.recordings.load import Recordings, as_recordings
from physident.recordings.recording import Recording, recording_count
from physident.setup_checks.check_setup import warn_of_setup
from physident.threads import one_thread
from physident.validation.predictions import Predictions, predicted

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Score:
    """How well a model predicts some recordings, after the filter, over their moving part.

    A relative error is 100 |measured - predicted| / |measured| [%], the mean over the recordings. ``relative`` (n,) counts
    rows whose filter window holds no rest of that joint, which are ``moving_share`` (n,) of all; it is NaN where there are
    none. ``relative_all`` (n,) counts all rows, with the friction of a joint at rest at its best value inside its band, and
    ``each`` (R, n) is that of each recording; ``rest_outside`` (n,) [%] of the samples at rest lie beyond that band. ``rms``
    (n,) is that of all rows, in the ``torque_unit`` of the joints. ``cutoff`` [Hz] is that of the filter, ``share`` that of the recordings' duration which
    was scored.
    """

    joints: tuple[str, ...]
    torque_unit: str
    rms: Array
    relative: Array
    moving_share: Array
    relative_all: Array
    rest_outside: Array
    each: Array
    cutoff: float
    share: float
    recordings: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """The score as plain numbers and texts for JSON."""
        return {
            "joints": list(self.joints),
            "rms": self.rms.tolist(),
            "relative_percent": [None if np.isnan(x) else float(x) for x in self.relative],
            "moving_share": self.moving_share.tolist(),
            "relative_percent_all": self.relative_all.tolist(),
            "relative_percent_each": self.each.tolist(),
            "rest_outside_percent": self.rest_outside.tolist(),
            "cutoff": self.cutoff,
            "share_scored": self.share,
            "recordings": list(self.recordings),
        }

    def __repr__(self) -> str:
        rows = [
            self._title,
            f"joint{f'rms [{self.torque_unit}]':>33}  error %  in motion  of rows   100 |measured - predicted| / |measured|",
        ]
        rows += [
            f"{j + 1:5d} {name:<22} {self.rms[j]:9.4g}  {self.relative_all[j]:7.2f}  {_or_dash(self.relative[j]):>9} {self.moving_share[j]:7.0%}"
            for j, name in enumerate(self.joints)
        ]
        return "\n".join(rows)

    @property
    def _title(self) -> str:
        return f"{recording_count(len(self.recordings))}, cutoff {self.cutoff:g} Hz, {100 * self.share:.0f} % of the time scored"

    def _repr_html_(self) -> str:
        head = ("joint", f"RMS [{self.torque_unit}]", "error [%]", "error in motion [%]", "of the rows")
        values = (self.rms, self.relative_all, self.relative, self.moving_share)
        rows = [
            (f"{j} {name}", f"{rms:.4g}", f"{all_rows:.2f}", _or_dash(moving), f"{share:.0%}")
            for j, name, rms, all_rows, moving, share in zip(
                range(1, len(self.joints) + 1), self.joints, *values, strict=True
            )
        ]
        return results_html(self._title, head, rows, "The error is 100 |measured − predicted| / |measured|.")


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
            b._title,
            f"joint{f'rms [{b.torque_unit}] before':>40} {'after':>8}  error % before  after  gain of rms %",
        ]
        for j, name in enumerate(b.joints):
            rows.append(
                f"{j + 1:5d} {name:<22} {b.rms[j]:16.4g} {a.rms[j]:8.4g} {b.relative_all[j]:15.2f} {a.relative_all[j]:6.2f} {self.reduction[j]:14.1f}"
            )
        return "\n".join([*rows, self._verdict])

    @property
    def _verdict(self) -> str:
        total = 100 * (1 - np.linalg.norm(self.after.rms / self.before.rms) / np.sqrt(len(self.before.rms)))
        level = (
            "as good as the first" if abs(total) < 0.05 else f"{abs(total):.1f} % {'better' if total > 0 else 'worse'}"
        )
        return f"verdict: the second model is {level} (RMS, every joint alike)"

    def _repr_html_(self) -> str:
        b, a = self.before, self.after
        head = ("joint", f"RMS before [{b.torque_unit}]", "after", "error before [%]", "after", "gain of RMS [%]")
        rows = [
            (f"{j + 1} {name}", *(f"{x.rms[j]:.4g}" for x in (b, a)), *(f"{x.relative_all[j]:.2f}" for x in (b, a)),
             f"{self.reduction[j]:.1f}")
            for j, name in enumerate(b.joints)
        ]  # fmt: skip
        return results_html(b._title, head, rows, self._verdict)


@one_thread
def validate(estimate: Estimate, recordings: Recordings, include_fitted: bool = False) -> Score:
    """Score of a model on recordings, with the model's filter; raises InputError for recordings it was fitted to.

    ``recordings`` are one or several recordings, paths or patterns; files are read with the model's layout. Currents
    without gains take the model's drive gains. ``include_fitted`` allows fitted recordings. Warns of a set-up that is wrong, as
    ``check_setup`` finds it.
    """
    given = as_recordings(recordings, estimate.model.robot, estimate.layout)
    _warn_of_setup(estimate, given)
    return scored(estimate, given, include_fitted)


def scored(estimate: Estimate, recordings: Recordings, include_fitted: bool = False) -> Score:
    """``validate`` without a word on the set-up, for a caller that has checked it."""
    recordings = as_recordings(recordings, estimate.model.robot, estimate.layout)
    if not recordings:
        raise InputError("no recordings given, expected at least one that the model was not fitted to")
    if not include_fitted:
        refuse_fitted(estimate, recordings)
    return _score(estimate, recordings, predicted(estimate, recordings))


def _warn_of_setup(estimate: Estimate, recordings: Sequence[Recording]) -> None:
    """Warn of a set-up that makes a score of recordings wrong."""
    warn_of_setup(estimate.model.robot, [one.with_default_drive_gains(estimate.drive_gains) for one in recordings])


def _score(estimate: Estimate, recordings: Sequence[Recording], predictions: Predictions) -> Score:
    every = np.ones_like(predictions.counted)
    each = np.array([_relative(predictions, predictions.recording == index, every) for index in range(len(recordings))])
    moving = np.array(
        [_relative(predictions, predictions.recording == index, predictions.moving) for index in range(len(recordings))]
    )
    seen = ~np.isnan(moving)
    total = sum(recording.duration for recording in recordings)
    return Score(
        joints=estimate.model.robot.joint_names,
        torque_unit=estimate.model.robot.torque_unit,
        rms=predictions.rms,
        relative=np.where(seen.any(axis=0), np.nansum(moving, axis=0) / np.maximum(seen.sum(axis=0), 1), np.nan),
        moving_share=predictions.moving.sum(axis=0) / np.maximum(predictions.counted.sum(axis=0), 1),
        relative_all=each.mean(axis=0),
        rest_outside=100 * predictions.rest_outside,
        each=each,
        cutoff=estimate.filter.cutoff,
        share=min(1.0, len(predictions.time) / predictions.rate / total),
        recordings=tuple(recording.source for recording in recordings),
    )


@one_thread
def compare(before: Estimate, after: Estimate, on: Recordings, include_fitted: bool = False) -> Gain:
    """The gain of one model over another on recordings that neither was fitted to, both through the same filter.

    Raises InputError as ``validate`` does, and for models of different joints or filters; warns as that does.
    """
    given = as_recordings(on, before.model.robot, before.layout)
    _warn_of_setup(before, given)
    return compared(before, after, given, include_fitted)


def compared(before: Estimate, after: Estimate, on: Recordings, include_fitted: bool = False) -> Gain:
    """``compare`` without a word on the set-up, for a caller that has checked it."""
    if before.filter != after.filter:
        raise InputError(
            f"the models use cutoffs of {before.filter.cutoff:g} and {after.filter.cutoff:g} Hz; expected one filter: identify both with the same --cutoff"
        )
    if before.model.robot.n != after.model.robot.n:
        raise InputError(
            f"the models have {before.model.robot.n} and {after.model.robot.n} joints; expected the same robot"
        )
    on = as_recordings(on, before.model.robot, before.layout)
    if not include_fitted:
        refuse_fitted(before, on)
        refuse_fitted(after, on)
    first, second = predicted(before, on), predicted(after, on)
    common = first.counted & second.counted
    return Gain(_score(before, on, first.restricted(common)), _score(after, on, second.restricted(common)))


def _relative(predictions: Predictions, rows: NDArray[np.bool_], chosen: NDArray[np.bool_]) -> Array:
    """Relative error (n,) [%] over some rows (M,), of which only the ``chosen`` (M, n) count; NaN where there are none."""
    if (joint := np.flatnonzero(~predictions.measured[rows].any(axis=0))).size:
        raise InputError(
            f"joint {joint[0] + 1}: the measured torque is zero throughout; expected a torque to compare with"
        )
    size = np.linalg.norm(predictions.measured[rows] * chosen[rows], axis=0)
    error = np.linalg.norm(predictions.residual[rows] * chosen[rows], axis=0)
    return np.where(size > 0, 100 * error / np.where(size > 0, size, 1.0), np.nan)


def _or_dash(percent: float) -> str:
    return "-" if np.isnan(percent) else f"{percent:.2f}"


def refuse_fitted(estimate: Estimate, recordings: Sequence[Recording]) -> None:
    """Raises InputError for a recording that the model was fitted to."""
    fitted = {source.sha256: source.path for source in estimate.sources}
    for recording in recordings:
        if recording.sha256 in fitted:
            raise InputError(
                f"{recording.source}: is a training recording of this model (as {fitted[recording.sha256]}); expected other recordings, or --include-fitted"
            )
