"""Ranges of position, speed and load that motions show, joint by joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.excitation.motion.motion import Motion
from physident.excitation.session.questions import Quantity, RangeQuestion
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)
INSTANTS = 200  # of a motion
OPEN = 0.5  # of what the pieces can show: a model used beyond twice its range is a guess
WANTED = 0.8  # of the same: what a session has to show of a range


@dataclass(frozen=True, eq=False)
class Ranges:
    """``lower`` and ``upper`` (3, n) of position [rad|m], speed [rad/s|m/s] and load [N m|N]."""

    lower: Array
    upper: Array

    @property
    def size(self) -> Array:
        """Their sizes (3, n)."""
        return self.upper - self.lower

    def joined(self, other: Ranges) -> Ranges:
        """The ranges of both."""
        return Ranges(np.minimum(self.lower, other.lower), np.maximum(self.upper, other.upper))


def ranges_of(model: Model, motion: Motion) -> Ranges:
    """The ranges of a motion."""
    return ranges_of_signals(model, motion.evenly(INSTANTS))


def ranges_of_signals(model: Model, signals: Signals) -> Ranges:
    """The ranges of signals, the load by a model."""
    load = model.refer(signals).load
    assert load is not None
    rows = [signals.q, signals.v, load]
    return Ranges(np.array([r.min(axis=0) for r in rows]), np.array([r.max(axis=0) for r in rows]))


def open_ranges(shown: Ranges | None, possible: Ranges) -> tuple[RangeQuestion, ...]:
    """The ranges of which too little was shown; all of them where nothing is known to have been shown."""
    room = np.maximum(possible.size, 1e-12)
    share = np.zeros_like(room) if shown is None else np.clip(shown.size / room, 0.0, 1.0)
    return tuple(
        RangeQuestion(joint=j + 1, quantity=quantity, shown=float(share[i, j]))
        for i, quantity in enumerate(QUANTITIES)
        for j in range(room.shape[1])
        if share[i, j] < OPEN and possible.size[i, j] > 1e-6
    )


def covered(questions: Sequence[RangeQuestion], shown: Ranges | None, possible: Ranges) -> Array:
    """The share (K,) of each open range's wanted part that is shown, 1 at most."""
    if shown is None:
        return np.zeros(len(questions))
    share = np.minimum(shown.size / np.maximum(WANTED * possible.size, 1e-12), 1.0)
    return np.array([share[QUANTITIES.index(one.quantity), one.joint - 1] for one in questions])
