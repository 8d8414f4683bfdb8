"""How much of a residual any function of a joint's state could take at most: states that were visited twice, far apart in time.

Two rows of one state differ by noise, and by what depends on something else. Half the mean squared difference is that part of the
variance; that states are only near each other adds to it, in proportion to their squared distance, which is extrapolated to zero.
Source: Gasser, Sroka, Jennen-Steinmetz, "Residual variance and residual pattern in nonlinear regression" (1986), for neighbours in
state instead of in order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ROWS = 3000  # evenly spaced, at most: the estimate's own scatter is then a few per cent
NEIGHBOURS = 64  # among which one is looked for that is far enough in time
FEWEST = 100  # pairs: fewer decide nothing
ONE_SIDED = 1.645  # standard errors: the bound holds nineteen times of twenty
GROUPS = 20  # of pairs in order of time, from which the standard error is computed


def predictable_share(
    residual: Array, states: Array, time: Array, recording: NDArray[np.intp], apart: float
) -> float | None:
    """The largest share (0 to 1) of a residual's (M,) power that a function of its ``states`` (M, d) can be, at 95 %.

    Rows count as independent where they are of different recordings or ``apart`` [s] in ``time`` (M,). None where too few states
    were visited twice.
    """
    from scipy.spatial import KDTree

    chosen = np.unique(np.linspace(0, len(residual) - 1, min(ROWS, len(residual))).astype(int))
    r, clock, run = residual[chosen], time[chosen], recording[chosen]
    spread = states[chosen].std(axis=0)
    x = states[chosen][:, spread > 0] / spread[spread > 0]
    power = float(np.mean(r**2))
    if power == 0 or not x.shape[1] or len(r) <= FEWEST:
        return None
    distance, index = KDTree(x).query(x, k=min(NEIGHBOURS, len(x)))
    distance, index = np.atleast_2d(distance), np.atleast_2d(index)
    far = (run[index] != run[:, None]) | (np.abs(clock[index] - clock[:, None]) > apart)
    first = np.argmax(far, axis=1)
    has = far[np.arange(len(r)), first]
    if has.sum() < FEWEST:
        return None
    at = np.flatnonzero(has)
    partner, near = index[at, first[at]], distance[at, first[at]] ** 2
    half = 0.5 * (r[at] - r[partner]) ** 2
    closest = near <= np.median(near)  # beyond, the curve is no line over the squared distance
    noise, error = _at_zero(near[closest], half[closest])
    return float(np.clip(1 - (noise - ONE_SIDED * error) / power, 0.0, 1.0))


def _at_zero(x: Array, y: Array) -> tuple[float, float]:
    """Intercept of a line through y over x whose slope is not negative, and its standard error over groups of neighbours in order."""
    parts = np.array_split(np.arange(len(x)), GROUPS)
    found = np.array([_intercept(np.delete(x, part), np.delete(y, part)) for part in parts])
    G = len(parts)
    return _intercept(x, y), float(np.sqrt((G - 1) / G * np.sum((found - found.mean()) ** 2)))


def _intercept(x: Array, y: Array) -> float:
    centred = x - x.mean()
    slope = max(0.0, float(centred @ y) / max(float(centred @ centred), 1e-300))
    return max(0.0, float(y.mean() - slope * x.mean()))
