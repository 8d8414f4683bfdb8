"""Two models on the same recordings: what each predicts, over the rows that count for both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from physident.diagnosis.result.extended_estimate import as_estimate
from physident.dynamics.model import Model
from physident.effects.contact import Contact
from physident.estimation.estimate import Estimate
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter
from physident.validation.scores import Predictions, predictions


@dataclass(frozen=True, eq=False)
class Pair:
    """What a model predicts ``before`` and ``after`` it was extended; ``after`` is None where nothing was found."""

    before: Predictions
    after: Predictions | None

    @property
    def both(self) -> tuple[Predictions, ...]:
        """One or two predictions, the model as it came first."""
        return (self.before,) if self.after is None else (self.before, self.after)


def predict_pair(
    before: Model | Estimate,
    after: Model | Estimate | None,
    recordings: Sequence[Recording],
    filter: Filter,
    drive_gains: tuple[float, ...] | None = None,
) -> Pair:
    """Both models' predictions of recordings through one filter; raises InputError as ``predictions`` does.

    ``drive_gains`` (n,) [N m/A] are for recordings that hold currents and no gains of their own.
    """
    first, *second = (
        predictions(replace(as_estimate(model, filter), filter=filter, drive_gains=drive_gains), recordings)
        for model in (before, after)
        if model is not None
    )
    if not second:
        return Pair(first, None)
    common = first.counted & second[0].counted
    return Pair(*(_only(p, common) for p in (first, second[0])))


def _only(p: Predictions, counted: np.ndarray) -> Predictions:
    return replace(p, measured=p.measured * counted, predicted=p.predicted * counted, counted=counted)


def rms(p: Predictions) -> np.ndarray:
    """Root mean square (n,) [N m|N] of measured minus predicted torque over the rows that count."""
    return np.sqrt(((p.measured - p.predicted) ** 2).sum(axis=0) / np.maximum(p.counted.sum(axis=0), 1))


def contact_bands(
    model: Model | None, p: Predictions, recordings: Sequence[Recording]
) -> tuple[tuple[float, float], ...]:
    """Start and end [s] of each contact of a model, on the axis of time in motion over recordings laid end to end."""
    bands = []
    for effect in model.effects if model is not None else ():
        if not isinstance(effect, Contact):
            continue
        for index, recording in enumerate(recordings):
            clock = p.time - recording.time[0]
            for start, end in effect.intervals if effect.recording in ("", recording.sha256) else ():
                rows = np.flatnonzero((p.recording == index) & (clock >= start) & (clock <= end))
                if len(rows):
                    bands.append((float(rows[0] / p.rate), float(rows[-1] / p.rate)))
    return tuple(bands)
