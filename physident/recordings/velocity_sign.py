"""The sign of a joint's velocity as far as a recording tells it: its expectation, and what remains uncertain.

Dry friction is a set at zero speed: while a joint rests, its friction takes any value up to the breakaway torque. The sign is
therefore not read off a noisy velocity. It is the expectation of sgn v over one sample, given the velocity's uncertainty;
while the position shows that the joint rests, it passes from the sign before to the sign after.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.recordings.rests import Rests

Array = NDArray[np.float64]
UNIFORM = 3**-0.5  # standard deviation of a number anywhere between -1 and 1
CERTAIN = 6.0  # standard deviations beyond which the sign of a normal value is certain to nine digits
SURE = 1e-9  # rad/s|m/s: a velocity is never known better


def velocity_sign(v: Array, half: Array, std: Array, rests: Sequence[Rests] | None) -> tuple[Array, Array]:
    """The sign of the velocities of k joints (k, N), and its standard deviation (k, N), which one crossing or rest has in common.

    During a sample the velocity [rad/s|m/s] passes from ``v - half`` to ``v + half`` (k, N); ``std`` (k,) is the standard
    deviation of ``v``, or the width over which the arm's own friction turns, or both in quadrature. At rest the sign of a joint
    that turns back passes straight from one to the other; one that goes on lets go in between; before the first and after
    the last motion nothing is known, and the sign is zero.
    """
    sign = expected_sign(v, half, std[:, None])
    # a torque is recorded at one instant of a sample or as a mean over it: where the sign turns inside, that is not known
    spread = np.sqrt(np.maximum(1 - sign**2, 0.0))
    for j, own in enumerate(rests or ()):
        if len(own.start):
            _pass_through(sign[j], spread[j], own, float(std[j]))
    return sign, spread


def _pass_through(sign: Array, spread: Array, rests: Rests, std: float) -> None:
    """Write the sign of one joint at rest, and its spread, into ``sign`` and ``spread`` (N,)."""
    index, which, u = rests.samples(len(sign))
    ends = np.nan_to_num(_sign_of_steady(np.array([rests.before, rests.after]), max(std, SURE)))
    before, after = ends[0, which], ends[1, which]
    through = before + (after - before) * u
    sign[index] = np.where(before * after < 0, through, through * (1 - 4 * u * (1 - u)))
    spread[index] = UNIFORM
    if rests.held is not None:
        held = rests.held[which]
        known = np.isfinite(held)
        sign[index[known]], spread[index[known]] = held[known], 0.0


def expected_sign(v: Array, half: Array, std: Array | float) -> Array:
    """Expected mean of sgn over velocities from ``v - half`` to ``v + half``, of which ``v`` has an uncertainty; arrays of one
    shape, or that broadcast to the shape of ``v``."""
    std = np.maximum(std, SURE)
    mean = np.sign(v)
    doubtful = ~(np.abs(v) > np.abs(half) + CERTAIN * std)  # NaN stays NaN
    half, std = np.broadcast_to(half, v.shape)[doubtful], np.broadcast_to(std, v.shape)[doubtful]
    mean[doubtful] = _expected_near_zero(v[doubtful], half, std)
    return mean


def _sign_of_steady(v: Array, std: Array | float) -> Array:
    """Expected sign of a velocity that does not change during a sample."""
    from scipy.special import erf

    return erf(v / (np.sqrt(2) * std))


def _expected_near_zero(v: Array, half: Array, std: Array) -> Array:
    from scipy.special import erf

    small = np.abs(half) < 1e-3 * std  # the mean over the sample is then the value in its middle
    step = np.where(small, std, half)

    def integral(x: Array) -> Array:
        z = x / (np.sqrt(2) * std)
        return x * erf(z) + std * np.sqrt(2 / np.pi) * np.exp(-(z**2))

    mean = (integral(v + step) - integral(v - step)) / (2 * step)
    return np.clip(np.where(small, _sign_of_steady(v, std), mean), -1.0, 1.0)
