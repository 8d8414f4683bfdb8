"""What a diagnosis requires of its recordings, checked before the search, which must not end in a refusal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.folds import FOLDS
from physident.dynamics.column_structure import kept_rows
from physident.dynamics.model import Model
from physident.effects.thermal import is_warming
from physident.errors import InputError
from physident.estimation.estimate import Estimate, as_estimate
from physident.recordings.checks import refuse_duplicates
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter, Signals
from physident.validation.predictions import predicted

CUT_OUT = 0.5  # of a holdout's samples: an arm never repeats one to the last digit of every encoder and sensor, but where it rests
MIX = np.uint64(0x9E3779B97F4A7C15)  # odd, and half of its bits set: every bit of a sample reaches its number


def refuse_repeated(
    model: Estimate | Model,
    recordings: Sequence[Recording],
    holdout: Sequence[Recording],
    before: Sequence[Recording] = (),
) -> None:
    """Raises InputError for a recording that came twice, for a holdout that was fitted or is diagnosed or is a part of one that is,
    and for a diagnosed one that is said to be from before."""
    refuse_duplicates(recordings)
    refuse_duplicates(before)
    for one in before:
        if one.sha256 in {r.sha256 for r in recordings}:
            raise InputError(
                f"{one.source}: diagnosed, and given as from before the change; expected other recordings from before"
            )
    refuse_duplicates(holdout)
    fitted = {source.sha256 for source in model.sources} if isinstance(model, Estimate) else set()
    for one in holdout:
        if one.sha256 in fitted or one.sha256 in {r.sha256 for r in recordings}:
            raise InputError(
                f"{one.source}: a holdout that was fitted or diagnosed already; expected a recording that was used for"
                " neither"
            )
        for other in recordings:
            if (share := _share_in(one, other)) > CUT_OUT:
                raise InputError(
                    f"{one.source}: {100 * share:.0f} % of its samples are those of {other.source}, which is diagnosed; expected a holdout"
                    " that nobody fitted, not a part of the same recording"
                )


def _share_in(one: Recording, other: Recording) -> float:
    """The share of a recording's distinct samples that are samples of another one, to the last digit of every position and effort."""
    if one.n != other.n:
        return 0.0
    mine, others = (np.unique(_codes(recording)) for recording in (one, other))
    return float(np.isin(mine, others, assume_unique=True).mean())


def _codes(recording: Recording) -> NDArray[np.uint64]:
    """A number (N,) for each sample of a recording, the same for equal ones alone, but for one chance in 2^64."""
    codes = np.zeros(len(recording.q), dtype=np.uint64)
    for column in (*recording.q.T, *recording.effort.T):
        bits = np.ascontiguousarray(column).view(np.uint64)
        codes = (codes ^ bits) * MIX
        codes ^= codes >> np.uint64(29)
    return codes


def check_lengths(model: Model, signals: Sequence[Signals], filter: Filter) -> None:
    """Raises InputError for a recording that leaves no rows after the filter, and where all together leave too few.

    Rows nearer than half the filter's length share most of their samples. Left-out rows are new to a model only in parts of
    that length, and ``FOLDS[0]`` parts are the fewest that can be left out in turn.
    """
    kept = [sum(len(piece.rows) for piece in kept_rows(model.robot, one, filter, moving_only=True)) for one in signals]
    for one, rows in zip(signals, kept, strict=True):
        if not rows:
            raise InputError(
                f"{one.source}: no rows are left after the filter, whose length is more than its motion; expected motion"
                f" for more than {_filter_length(one, filter):.2g} s, or leave it out"
            )
    duration = sum(rows * filter.decimation(one.rate) / one.rate for one, rows in zip(signals, kept, strict=True))
    needed = FOLDS[0] / 2 * max(_filter_length(one, filter) for one in signals)
    if duration < needed:
        names = ", ".join(one.source for one in signals)
        raise InputError(
            f"{names}: {duration:.2g} s of motion are left after the filter, expected {needed:.2g} s or more, so that"
            f" {FOLDS[0]} parts can be left out in turn; record longer, or raise the cutoff"
        )


def _filter_length(signals: Signals, filter: Filter) -> float:
    """How long [s] the filter is."""
    return (len(filter.taps(signals.rate)) - 1) / signals.rate


def check_holdout(
    model: Estimate | Model, recordings: Sequence[Recording], holdout: Sequence[Recording], filter: Filter
) -> None:
    """Raises InputError for a holdout that could not be scored after ``recordings`` are diagnosed; nothing is compared, no
    score is made."""
    if not holdout:
        return
    _refuse_without_temperature(recordings, holdout)
    start = as_estimate(model, filter)
    ready = predicted(start, holdout)
    for index, one in enumerate(holdout):
        silent = ~ready.measured[ready.recording == index].any(axis=0)
        if silent.any():
            raise InputError(
                f"{one.source}: the measured torque of joint {int(np.argmax(silent)) + 1} is zero throughout;"
                " expected a holdout with a torque to compare with"
            )


def _refuse_without_temperature(recordings: Sequence[Recording], holdout: Sequence[Recording]) -> None:
    """Friction that falls with a measured temperature may be found: the holdout is then scored with its own."""
    if not all(r.temperature is not None and is_warming(r.temperature) for r in recordings):
        return
    for one in holdout:
        if one.temperature is None:
            raise InputError(
                f"{one.source}: a holdout without temperatures, which the diagnosed recordings have; expected temperature_1.."
                " [degC] in all of them or in none"
            )
