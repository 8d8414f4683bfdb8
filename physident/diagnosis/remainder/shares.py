"""Which share of a residual's power a curve explains, and which lies where a joint hardly moves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
BINS = 10
SLOWEST = 0.2  # of the rows: about reversals and in rests a joint moves so slowly, and a fifth of noise is found there
MOST_OF_IT = 3 * SLOWEST  # of the power, above which that is told


def share_of_curve(r: Array, x: Array, worth: float) -> float:
    """Share of a residual's (M,) power that its mean over bins of equal count of ``x`` (M,) explains, beyond what as many bins explain of noise;
    ``worth``: how many independent samples the residual is."""
    label = np.minimum(np.argsort(np.argsort(x)) * BINS // len(x), BINS - 1)
    means = np.bincount(label, r, BINS) / np.maximum(np.bincount(label, minlength=BINS), 1)
    share = float(np.sum(means[label] ** 2) / max(float(r @ r), 1e-300))
    return max(0.0, share - BINS / worth)


def share_of_slowest(r: Array, v: Array) -> float:
    """Share of a residual's (M,) power in the fifth of the rows in which a joint of velocity ``v`` (M,) moves slowest, or stands."""
    slowest = np.argsort(np.abs(v), kind="stable")[: round(SLOWEST * len(v))]
    return float(r[slowest] @ r[slowest] / max(float(r @ r), 1e-300))


def slowest_in_words(share: float) -> str:
    """That most of a residual lies where its joint hardly moves; empty where it does not."""
    if share <= MOST_OF_IT:
        return ""
    return f"{100 * share:.0f} % of it lies in the fifth of the time in which the joint moves slowest or stands, where friction turns or holds"
