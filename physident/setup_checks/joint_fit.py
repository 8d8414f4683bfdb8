"""How well each channel of effort follows each joint of the description, by least squares with terms that cannot be negative.

Gravity, inertia, rotor and friction of a healthy arm all have positive coefficients, whatever its masses are. A channel with
the wrong sign or of another joint has not, and then little of it is explained.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.setup_checks.rows import Rows

Array = NDArray[np.float64]
TINY = 1e-6  # of the torque's norm: a column below it is zero
CERTAIN = 0.02  # share of a torque's variance: a fit that leaves less is as good as any


@dataclass(frozen=True, eq=False, kw_only=True)
class Moments:
    """Sums of products over blocks: ``inner`` (B, n, 5, 5) of the columns of each joint, ``cross`` (B, n, n, 5) of channel i
    with the columns of joint j, ``power`` (B, n) of the channels."""

    inner: Array
    cross: Array
    power: Array

    def without(self, block: int | None) -> tuple[Array, Array, Array]:
        """Totals over the blocks, one left out unless None."""
        chosen = np.arange(len(self.power)) != (-1 if block is None else block)
        return self.inner[chosen].sum(axis=0), self.cross[chosen].sum(axis=0), self.power[chosen].sum(axis=0)

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return len(self.power)


def moments_of(rows: Rows) -> Moments:
    """The moments of rows."""
    columns, torque = rows.columns, rows.centred(rows.torque)
    inner, cross, power = [], [], []
    for block in np.unique(rows.block):
        chosen = rows.block == block
        x, y = columns[:, chosen], torque[chosen]
        inner.append(np.einsum("jmk,jml->jkl", x, x))
        cross.append(np.einsum("jmk,mi->ijk", x, y))
        power.append((y**2).sum(axis=0))
    return Moments(inner=np.array(inner), cross=np.array(cross), power=np.array(power))


def unexplained(moments: Moments, block: int | None = None) -> tuple[Array, Array]:
    """Shares (n, n) of the variance of channel i that the columns of joint j leave, with its sign as it is and turned over."""
    inner, cross, power = moments.without(block)
    n = len(power)
    result = np.ones((2, n, n))
    for j in range(n):
        scale = np.sqrt(np.maximum(np.diag(inner[j]), 0.0))
        for i in np.flatnonzero(power > 0):
            kept = scale > TINY * np.sqrt(power[i])
            if not kept.any():
                continue
            factor = _factor(inner[j][np.ix_(kept, kept)] / np.outer(scale[kept], scale[kept]))
            b = cross[i, j][kept] / scale[kept]
            for k, sign in enumerate((1.0, -1.0)):
                result[k, i, j] = 1 - _explained(factor, sign * b) / power[i]
    return np.clip(result[0], 0.0, 1.0), np.clip(result[1], 0.0, 1.0)


def own_unexplained(moments: Moments, block: int | None = None) -> Array:
    """Shares (n,) of the variance of each channel that the columns of its own joint leave."""
    inner, cross, power = moments.without(block)
    result = np.ones(len(power))
    for j in np.flatnonzero(power > 0):
        scale = np.sqrt(np.maximum(np.diag(inner[j]), 0.0))
        kept = scale > TINY * np.sqrt(power[j])
        if kept.any():
            factor = _factor(inner[j][np.ix_(kept, kept)] / np.outer(scale[kept], scale[kept]))
            result[j] = 1 - _explained(factor, cross[j, j][kept] / scale[kept]) / power[j]
    return np.clip(result, 0.0, 1.0)


def coefficients(moments: Moments, block: int | None = None) -> Array:
    """Ordinary least-squares coefficients (n, 5) of each channel on the columns of its own joint; zero for a zero column."""
    inner, cross, power = moments.without(block)
    result = np.zeros((len(power), 5))
    for j in np.flatnonzero(power > 0):
        scale = np.sqrt(np.maximum(np.diag(inner[j]), 0.0))
        kept = scale > TINY * np.sqrt(power[j])
        if kept.any():
            matrix = inner[j][np.ix_(kept, kept)] / np.outer(scale[kept], scale[kept])
            result[j, kept] = np.linalg.pinv(matrix, rcond=1e-9, hermitian=True) @ (cross[j, j][kept] / scale[kept])
            result[j, kept] /= scale[kept]
    return result


def dissipation(rows: Rows, moments: Moments) -> Array:
    """Mean power (n,) [W] of the friction that least squares finds on each joint; negative where it would drive the motion."""
    friction = np.einsum("jmk,jk->mj", rows.columns[:, :, 3:], coefficients(moments)[:, 3:])
    return (friction * rows.centred(rows.v)).mean(axis=0)


def inertia_factor(rows: Rows, moments: Moments, block: int | None = None) -> float:
    """Fitted torque of links' and rotors' inertia over the description's, mean over the joints that move and where the latter is large."""
    own = inertia_factors(rows, moments, block)
    strong = rows.strong() & rows.moving() & np.isfinite(own)
    return float(np.exp(np.mean(np.log(np.maximum(own[strong], 1e-6))))) if strong.any() else float("nan")


def inertia_factors(rows: Rows, moments: Moments, block: int | None = None) -> Array:
    """The same of each joint (n,); NaN where the description has no inertia that moves."""
    columns, theta = rows.columns, coefficients(moments, block)
    fitted, nominal = np.einsum("jmk,jk->jm", columns[:, :, 1:3], theta[:, 1:3]), columns[:, :, 1]
    power = (nominal**2).sum(axis=1)
    return np.where(power > 0, (fitted * nominal).sum(axis=1) / np.maximum(power, 1e-300), np.nan)


def _factor(matrix: Array) -> Array:
    """Upper triangular factor of a scaled matrix of products, kept regular."""
    lower: Array = np.asarray(np.linalg.cholesky(matrix + 1e-10 * np.eye(len(matrix))), dtype=np.float64)
    return lower.T


def _explained(factor: Array, b: Array) -> float:
    """Variance that non-negative coefficients explain: of ``factor`` x nearest to the right side with products ``b``."""
    from scipy.optimize import nnls

    right = np.linalg.solve(factor.T, b)
    x, _ = nnls(factor, right)
    return float(2 * b @ x - np.sum((factor @ x) ** 2))
