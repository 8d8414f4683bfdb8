"""What stays unexplained beside what a model leaves of its own recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.remainder.own_error import OwnError
from physident.diagnosis.remainder.unexplained import EXACT, Unexplained

Array = NDArray[np.float64]


def beside_own(
    unexplained: Sequence[Unexplained],
    own: OwnError,
    torque: Array,
    compared: float,
    louder: float,
    unfitted: Mapping[int, float] | None = None,
) -> tuple[Unexplained, ...]:
    """The same beside what a model leaves of its ``own`` recordings, where these are exact beside what a sensor would tell of
    the ``torque`` (M, n). The share of rows that are ``compared`` holds the errors of two recordings of one motion; where all are, what the
    model errs by along motions that it was not fitted to was taken off, and makes nothing usual. Noise alone may be ``louder`` times as large.
    ``unfitted``: the RMS [N m|N] that the model errs by with the values from before, of the joints (from 1) on which nothing that was found acts."""
    sigma = np.maximum(own.rms, EXACT * np.sqrt(np.mean(torque**2, axis=0))) * np.sqrt(1 + compared) * louder
    usual = [None] * len(sigma) if own.times is None or compared == 1 else own.times.tolist()
    errors = unfitted or {}
    return tuple(
        replace(
            one,
            times_own=one.rms / float(sigma[one.joint - 1]),
            usual_times=usual[one.joint - 1],
            unproven=errors[one.joint] / float(sigma[one.joint - 1]) if one.joint in errors else None,
        )
        for one in unexplained
    )
