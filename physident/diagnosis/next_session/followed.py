"""Whether the recordings of a session are those of its pieces."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from physident.diagnosis.next_session.saved_session import SavedSession
from physident.errors import InputError, warn
from physident.excitation.motion.motion import Motion
from physident.recordings.preparation import prepare
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter, Signals

APART = 0.5  # of the RMS position about its mean: motions that have nothing in common are 1.4 of it apart


def check_followed(session: SavedSession, recordings: Mapping[str, Recording], filter: Filter) -> None:
    """Warn of recordings, by the names of their legs, that do not follow the planned motion; nothing is said of those with gaps.

    Raises InputError for a recording that is of another piece.
    """
    motions = {leg.name: motion for leg, motion in zip(session.legs, session.motions, strict=True)}
    for name, recording in recordings.items():
        made = prepare(recording, filter)
        if len(made.starts) > 1 or follows(made, motions[name]):
            continue
        if others := [other for other, motion in motions.items() if follows(made, motion)]:
            raise InputError(
                f"{recording.source}: given as piece {name}, but its motion is that of {others[0]}; expected the recordings in the"
                " order of the session, or file names that begin with the pieces' names"
            )
        warn(
            f"{recording.source}: does not follow the planned motion of piece {name}, so what this piece was to settle may stay open;"
            " record it again as planned"
        )


def follows(made: Signals, motion: Motion) -> bool:
    """Whether the positions of a recording are nearly those of a planned motion, whenever it began."""
    from scipy.signal import fftconvolve

    planned = motion.states(np.arange(0.0, motion.duration, 1 / made.rate)).q
    middle, n = planned.mean(axis=0), len(planned)
    wanted = planned - middle
    # a recording may begin or end a little within the motion, and stood still before and after it
    shown = np.pad(made.q - middle, ((n // 4, n // 4), (0, 0)), mode="edge")
    if len(shown) < n:
        return False
    cross = sum(fftconvolve(shown[:, j], wanted[::-1, j], "valid") for j in range(wanted.shape[1]))
    power = np.concatenate([[0.0], np.cumsum((shown**2).sum(axis=1))])
    apart = power[n:] - power[:-n] + np.sum(wanted**2) - 2 * cross
    return bool(apart.min() <= APART**2 * np.sum(wanted**2))
