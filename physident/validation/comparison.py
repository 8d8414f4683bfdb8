"""Two models on the same recordings: what each predicts, over the rows that count for both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from physident.dynamics.model import Model
from physident.effects.contact import Contact
from physident.estimation.estimate import Estimate, as_estimate
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter
from physident.validation.predictions import Predictions, predict


@dataclass(frozen=True, eq=False)
class Pair:
    """Predictions ``before`` and ``after`` a model was extended; ``after`` is None where it was not extended."""

    before: Predictions
    after: Predictions | None

    @property
    def both(self) -> tuple[Predictions, ...]:
        """One or two predictions, the original model's first."""
        return (self.before,) if self.after is None else (self.before, self.after)


def predict_pair(
    before: Model | Estimate,
    after: Model | Estimate | None,
    recordings: Sequence[Recording],
    filter: Filter,
    drive_gains: tuple[float, ...] | None = None,
) -> Pair:
    """Both models' predictions of recordings through one filter; raises InputError as ``predict`` does.

    ``drive_gains`` (n,) [N m/A] are used for recordings of currents that have no gains.
    """

    def predicted(model: Model | Estimate) -> Predictions:
        return predict(replace(as_estimate(model, filter), filter=filter, drive_gains=drive_gains), recordings)

    first = predicted(before)
    if after is None:
        return Pair(first, None)
    second = predicted(after)
    common = first.counted & second.counted
    return Pair(first.restricted(common), second.restricted(common))


def contact_bands(
    model: Model | None, predictions: Predictions, recordings: Sequence[Recording]
) -> tuple[tuple[float, float], ...]:
    """Start and end [s] of each contact of a model, on the axis of time in motion over recordings laid end to end."""
    bands = []
    contacts = [effect for effect in (model.effects if model is not None else ()) if isinstance(effect, Contact)]
    for contact in contacts:
        for index, recording in enumerate(recordings):
            clock = predictions.time - recording.time[0]
            for start, end in contact.intervals if contact.recording in ("", recording.sha256) else ():
                rows = np.flatnonzero((predictions.recording == index) & (clock >= start) & (clock <= end))
                if len(rows):
                    bands.append((float(rows[0] / predictions.rate), float(rows[-1] / predictions.rate)))
    return tuple(bands)
