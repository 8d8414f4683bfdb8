"""Bands under the curves: when each recording runs, and when the arm was in contact."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from physident.dynamics.model import Model
from physident.effects.contact import Contact
from physident.graphics import style
from physident.graphics.session.data import SessionData, spans
from physident.graphics.session.log import duration, rgb

if TYPE_CHECKING:
    import rerun as rr

NOTHING = "-"  # the state between two bands, which is not drawn
SHADES = ("#5F6B7A", "#8A97A6")  # of the recordings, alternating


def contact_intervals(data: SessionData, model: Model | None) -> list[tuple[float, float]]:
    """Start and end [s] on the session's clock of every contact of a model, in the recordings shown."""
    found = []
    for effect in model.effects if model is not None else ():
        if isinstance(effect, Contact):
            for recording, start, _ in spans(data):
                if effect.recording in ("", recording.sha256):
                    found += [(start + a, start + b) for a, b in effect.intervals if a < recording.duration]
    return sorted(found)


def log_bands(rec: rr.RecordingStream, data: SessionData, contacts: Sequence[tuple[float, float]]) -> None:
    """Log a band for each recording, and one for each contact where there are any."""
    names = [r.source.replace("\\", "/").rsplit("/", 1)[-1] for r in data.recordings]
    recorded = [(start, end, name) for name, (_, start, end) in zip(names, spans(data), strict=True)]
    colours = {name: SHADES[i % len(SHADES)] for i, name in enumerate(names)}
    _log_lane(rec, "bands/recording", recorded, colours)
    if contacts:
        bands = [
            (start, end, str(number)) for number, (start, end) in enumerate(contacts, 1)
        ]  # a word would be cut off
        _log_lane(rec, "bands/contact", bands, {name: style.effect_colour("contact") for *_, name in bands})


def _log_lane(
    rec: rr.RecordingStream, path: str, bands: Sequence[tuple[float, float, str]], colours: dict[str, str]
) -> None:
    import rerun as rr

    times, states = [], []
    for start, end, name in bands:
        if times and times[-1] >= start:  # the previous band ends where this one starts
            times, states = times[:-1], states[:-1]
        times += [start, end]
        states += [name, NOTHING]
    values = [*colours, NOTHING]
    painted = [[*rgb(colour), 255] for colour in colours.values()]
    look = rr.StateConfiguration(
        values=values, colors=[*painted, [0, 0, 0, 0]], visible=[True] * len(colours) + [False]
    )
    rec.log(path, look, static=True)
    rec.send_columns(path, [duration(np.array(times))], rr.StateChange.columns(state=states))
