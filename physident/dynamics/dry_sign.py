"""The sign of joints' velocities along signals, as dry friction sees it."""

from __future__ import annotations

from collections.abc import Sequence
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from physident.recordings.signals import Signals
from physident.recordings.velocity_sign import velocity_sign

Array = NDArray[np.float64]
SHARPEST = 1e-3  # rad/s: width of the sign of a state about which nothing else is known, such as one of a simulation
WIDEST = 0.064  # rad/s: over no wider speed does any dry friction turn that is identified
SMOOTH_SIGN_SOURCE = f"np.tanh(v / {SHARPEST})"  # ``smooth_sign`` in exported code
ERF_WIDTH = np.sqrt(2 / np.pi)  # standard deviation of the velocity whose expected sign is as steep as tanh(v / 1)

REMEMBERED = (
    1 << 14
)  # samples at most: a chunk, which many effects ask for the same signs and which is gone before the next one comes
_remembered: WeakKeyDictionary[Signals, dict[tuple[int, float], tuple[Array, Array]]] = WeakKeyDictionary()


def smooth_sign(v: Array, width: Array | float = SHARPEST) -> Array:
    """The sign tanh(v / width) of exactly known velocities; ``v`` and ``width`` in the same unit [rad/s|m/s]."""
    return np.tanh(v / np.maximum(width, SHARPEST))


def sign_of_velocity(signals: Signals, joints: Sequence[int], width: Array | None = None) -> Array:
    """The sign (k, N) of the velocities of some joints (indices from 0), as dry friction sees it.

    ``width`` (k,) [rad/s|m/s] is that over which the arm's own friction turns; None takes the signals' own, zero is dry.
    An uncertain velocity adds its uncertainty. A dry joint at rest passes from the sign before to that after.
    """
    return _signs(signals, joints, width)[0]


def sign_spread(signals: Signals, joints: Sequence[int], width: Array | None = None) -> Array:
    """Standard deviation (k, N) of ``sign_of_velocity``, which the samples of one crossing or rest have in common."""
    return _signs(signals, joints, width)[1]


def _signs(signals: Signals, joints: Sequence[int], width: Array | None) -> tuple[Array, Array]:
    index = list(joints)
    if width is None:
        width = np.zeros(len(index)) if signals.transition is None else signals.transition[index]
    if signals.velocity_std is None:
        sign = smooth_sign(signals.v.T[index], width[:, None])
        return sign, np.zeros_like(sign)
    known = _remembered.setdefault(signals, {}) if len(signals.time) <= REMEMBERED else {}
    keys = list(zip(index, width.tolist(), strict=True))
    new = [key for key in dict.fromkeys(keys) if key not in known]
    if new:
        joints, widths = [j for j, _ in new], np.array([w for _, w in new])
        std = np.hypot(signals.velocity_std[joints], ERF_WIDTH * widths)
        half = signals.a.T[joints] / (2 * signals.rate)
        rests = None if signals.rests is None else [signals.rests[j] for j in joints]
        known.update(zip(new, zip(*velocity_sign(signals.v.T[joints], half, std, rests), strict=True), strict=True))
    shape = len(keys), len(signals.time)
    sign, spread = (np.array([known[key][part] for key in keys]).reshape(shape) for part in (0, 1))
    return sign, spread
