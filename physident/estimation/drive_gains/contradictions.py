"""Whether recordings with a load agree with one another and with those without: gains from others mean nothing."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.estimation.drive_gains.equations import GainEquations, GainSolution
from physident.estimation.payload.payload import APART, LEFT, LEVEL
from physident.estimation.uncertainty import BLOCK_PERIODS, FEWEST_BLOCKS, block_labels, correlation_rows

Array = NDArray[np.float64]
MOMENT = slice(0, 3)  # the first moments among the load's nine parameters beside its mass


def contradictions(equations: GainEquations, solution: GainSolution, names: Sequence[str]) -> tuple[str, ...]:
    """Why gains and intervals cannot be believed, in words; empty where they can. ``names`` are those of the recordings."""
    left = np.column_stack(
        [
            (joint.current - (joint.values @ solution.x[joint.columns] + joint.known) / gain) / noise
            for joint, gain, noise in zip(equations.joints, solution.gains, solution.noise, strict=True)
        ]
    )
    recording = equations.regressor.recording
    loaded = np.unique(recording[equations.carried]).tolist()
    return (*_different_loads(equations, solution, left, loaded, names), *_worse_with_load(equations, left))


def _different_loads(
    equations: GainEquations, solution: GainSolution, left: Array, loaded: Sequence[int], names: Sequence[str]
) -> list[str]:
    """Two recordings whose loads differ: fitted apart, their centres of mass lie apart by more than their errors."""
    if len(loaded) < 2:
        return []
    recording = equations.regressor.recording
    each = {k: _own_load(equations, solution, left, recording == k) for k in loaded}
    from scipy.stats import chi2

    found = []
    for a, b in ((a, b) for i, a in enumerate(loaded) for b in loaded[i + 1 :]):
        moments = [solution.load[1:4] + each[k][0][MOMENT] for k in (a, b)]
        change, far = moments[0] - moments[1], max(float(np.linalg.norm(m)) for m in moments)
        covariance = (each[a][1] + each[b][1])[MOMENT, MOMENT]
        distance = float(change @ np.linalg.pinv(covariance, hermitian=True) @ change)
        if distance > float(chi2.ppf(LEVEL, 3)) and np.linalg.norm(change) > APART * far:
            found.append((distance, a, b))
    if not found:
        return []
    _, a, b = max(found)
    centres = [(solution.load[1:4] + each[k][0][MOMENT]) / equations.mass * 1000 for k in (a, b)]
    at = [
        f"({', '.join(f'{x:.0f}' for x in centre)}) mm in {names[k]}" for k, centre in zip((a, b), centres, strict=True)
    ]
    return [
        f"the recordings with load contradict each other: its centre of mass is at {at[0]} and at {at[1]}; use one load, mounted"
        " alike; where it was, friction of the gears that grows with load shows as this"
    ]


def _own_load(
    equations: GainEquations, solution: GainSolution, left: Array, rows: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """What a load of its own changes in some rows: its parameters (9,), and their covariance (9, 9)."""
    blocks, gradients, H = _labels(equations, left, rows), [], np.zeros((9, 9))
    for j, joint in enumerate(equations.joints):
        at = joint.columns - (equations.size - 9)
        A = np.zeros((int(rows.sum()), 9))
        A[:, at[at >= 0]] = joint.values[rows][:, at >= 0] / (solution.gains[j] * solution.noise[j])
        H += A.T @ A
        gradients.append(A)
    inverse = np.linalg.pinv(H, rcond=1e-10, hermitian=True)
    slope = np.sum([A.T @ left[rows, j] for j, A in enumerate(gradients)], axis=0)
    change = inverse @ slope
    scores = np.zeros((blocks[-1] + 1, 9))
    for j, A in enumerate(gradients):
        np.add.at(scores, blocks, A * (left[rows, j] - A @ change)[:, None])
    meat = scores.T @ scores * len(scores) / max(len(scores) - 1, 1)
    return change, inverse @ meat @ inverse


def _labels(equations: GainEquations, left: Array, rows: NDArray[np.bool_]) -> NDArray[np.intp]:
    """The block (R,) of each of some rows, blocks so long that they are nearly independent."""
    length = math.ceil(BLOCK_PERIODS * float(correlation_rows(equations.regressor, left).max()))
    return block_labels(equations.regressor.segment[rows], max(1, min(length, int(rows.sum()) // FEWEST_BLOCKS)))


def _worse_with_load(equations: GainEquations, left: Array) -> list[str]:
    """Whether the model leaves far more in the recordings with load than in those without."""
    carried = equations.carried
    sizes = [np.sqrt((left[rows] ** 2).mean(axis=0)) for rows in (carried, ~carried)]
    ratios = sizes[0] / np.maximum(sizes[1], 1e-300)
    worse = np.flatnonzero(ratios > LEFT)
    if not len(worse):
        return []
    joints = ", ".join(f"{ratios[j]:.2g} times on joint {j + 1}" for j in worse)
    return [
        f"with the load more current is left unexplained than without ({joints}): the load, its mounting, a gain or the friction is another one"
    ]
