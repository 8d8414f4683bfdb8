"""The share that most joints have in common, each with a scatter of its own about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm

Array = NDArray[np.float64]
TIMES = 20  # that a share and the scatter about it, which is a part of it, are found from each other: they settle within a few


@dataclass(frozen=True, kw_only=True)
class CommonShare:
    """A share in ``percent`` with its standard ``error``, how far joints are apart by ``chi_squared``, and the ``others`` (from 1), which
    have another one."""

    percent: float
    error: float
    chi_squared: float
    others: tuple[int, ...]


def share_of_most(shares: Array, covariance: Array, uneven: float, deviations: float) -> CommonShare | None:
    """The share that the most joints have in common, of their ``shares`` (n,) [%] with a ``covariance`` (n, n).

    Each scatters about it by the part ``uneven`` of it and by its own error; ``deviations`` of a normal distribution are the level of
    every test. None where half of the joints have another, or where what they have in common may be none.
    """
    joints = np.arange(len(shares))
    now = _share_of(shares, covariance, joints, uneven)
    while now.chi_squared > limit_of(len(joints) - 1, deviations):
        fewer = [np.delete(joints, k) for k in range(len(joints))]
        if 2 * len(fewer[0]) <= len(shares):
            return None
        tried = [_share_of(shares, covariance, some, uneven) for some in fewer]
        best = int(np.argmin([one.chi_squared for one in tried]))
        joints, now = fewer[best], tried[best]
    return now if abs(now.percent) > deviations * now.error else None


def _share_of(shares: Array, covariance: Array, joints: NDArray[np.intp], uneven: float) -> CommonShare:
    """What some joints (from 0) have in common, weighted by their scatter about it."""
    own, noise = shares[joints], covariance[np.ix_(joints, joints)]
    common, weights = float(np.median(own)), np.zeros_like(noise)
    for _ in range(TIMES):
        weights = np.linalg.inv(noise + (uneven * common) ** 2 * np.eye(len(own)))
        common = float(weights.sum(axis=0) @ own / weights.sum())
    left = own - common
    others = np.setdiff1d(np.arange(len(shares)), joints) + 1
    return CommonShare(
        percent=common,
        error=float(weights.sum() ** -0.5),
        chi_squared=float(left @ weights @ left),
        others=tuple(others.tolist()),
    )


def limit_of(count: int, deviations: float) -> float:
    """What chi squared of so many numbers exceeds as often as a normal number exceeds some standard deviations."""
    return float(chi2.isf(norm.sf(deviations), count))
