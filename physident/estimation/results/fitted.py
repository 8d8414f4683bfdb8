"""The recordings that a model was fitted to, where they are still at hand."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace

from physident.estimation.estimated_model import EstimatedModel, Source
from physident.recordings.load import if_at_hand
from physident.recordings.recording import Recording


def fitted_recordings(estimate: EstimatedModel, given: Sequence[Recording] = ()) -> tuple[Recording, ...]:
    """The recordings that a model was fitted to, where all of them are at hand; otherwise none."""
    found = [recording for recording in each_at_hand(estimate, given) if recording is not None]
    return tuple(found) if len(found) == len(estimate.sources) else ()


def each_at_hand(estimate: EstimatedModel, given: Sequence[Recording] = ()) -> tuple[Recording | None, ...]:
    """Each recording that a model was fitted to: with the estimate itself, among those ``given``, or as a file that has not changed
    since; None for one that is not at hand."""
    here = {recording.sha256: recording for recording in (*estimate.fitted, *given)}
    found = [here.get(source.sha256) or _read_again(estimate, source) for source in estimate.sources]
    return tuple(one and one.with_default_drive_gains(estimate.drive_gains) for one in found)


def _read_again(estimate: EstimatedModel, source: Source) -> Recording | None:
    """A recording from its path, which may be relative to the folder of the model's file, or from that folder."""
    folder, names = os.path.dirname(estimate.path or ""), estimate.model.robot.joint_names
    places = (source.path, os.path.join(folder, source.path), os.path.join(folder, os.path.basename(source.path)))
    read = (if_at_hand(place, source.sha256, estimate.layout, names) for place in dict.fromkeys(places))
    recording = next((one for one in read if one), None)
    return None if recording is None else replace(recording, source=source.path)  # under the name that the model knows
