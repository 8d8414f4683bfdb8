"""Noise-free torques, as of a simulator, are judged as if they were known to a resolution, and not to the last digit.

What resampling, differences and the filter leave of exact data is a millionth of the torque, but no noise: it follows the
motion, and every effect explains some of it. White noise of the size of the resolution is added to such torques. Then
surrogates, thresholds and intervals mean what they mean for measured torques, and causes below it are not looked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor
from physident.errors import warn
from physident.estimation.weighting import noise_floor
from physident.recordings.signals import Filter, Signals

Array = NDArray[np.float64]
RESOLUTION = 5e-4  # of a joint's torque: rounding by the 12 bits of a current loop whose range is four times as large


def at_resolution(
    signals: Sequence[Signals], regressor: Regressor, sigma: Array, filter: Filter, seed: int
) -> list[Signals] | None:
    """The signals with noise, where the residual ``sigma`` (n,) [N m|N] of a joint lies below the resolution of any torque.

    None where no joint's does. Every joint gets noise: the residual of another may hide that it is exact too, and beside
    noise of its own the resolution is nothing. It has the size of the resolution after the filter; ``seed`` draws it.
    """
    floor = noise_floor(regressor, RESOLUTION)
    exact = sigma < floor
    if not exact.any():
        return None
    joints = ", ".join(str(j + 1) for j in np.flatnonzero(exact))
    warn(
        f"the torque of joint {joints} has no noise, as a simulator's: torques are taken as known to {RESOLUTION:g} of their"
        " size, and smaller causes are not looked for"
    )
    rng = np.random.default_rng([seed, 29])
    result = []
    for one in signals:
        assert one.torque is not None
        passed = np.linalg.norm(filter.taps(one.rate))  # of the size of white noise
        noise = rng.standard_normal(one.torque.shape) * (floor / passed)
        result.append(replace(one, torque=one.torque + noise))
    return result
