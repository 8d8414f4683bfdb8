"""The workspace's limits on a Fourier series: constraints for IPOPT, and one number a motion for the genetic algorithm."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from physident.excitation.limits.constraints import Constraints
from physident.excitation.limits.workspace import Workspace
from physident.excitation.motion.series import Series

Array = NDArray[np.float64]
NODES = 48  # instants of a period at which the constraints hold
ZERO_DERIVATIVE = 1e-12  # in units of the limit: a smaller derivative is rounding
SEED = 0


def workspace_constraints(workspace: Workspace, series: Series) -> Constraints:
    """The limits of a workspace as constraints on motions of a series, at ``NODES`` instants of a period.

    At each instant: the joints with a torque limit, the square of the tool speed, the capsules' ends above the table, and
    the pairs of capsules; all in units of their limit.
    """
    n, m = series.n, series.m
    bases = series.basis(np.arange(NODES) / NODES)
    values_of, jacobian_of = (function.map(NODES) for function in workspace.arm.functions)

    def state(y: Array) -> Array:
        coefficients = y.reshape(n, m)
        return np.concatenate([coefficients @ basis.T for basis in bases])

    def value(y: Array) -> Array:
        values = np.asarray(values_of(state(y))).T
        return np.concatenate([limit.constraint(values) for limit in workspace.limits], axis=1).ravel()

    def gradient(y: Array) -> Array:
        x = state(y)
        values = np.asarray(values_of(x)).T
        jacobian = np.swapaxes(np.asarray(jacobian_of(x)).T.reshape(NODES, 3 * n, -1), 1, 2)  # CasADi stacks columns
        by_state = np.concatenate([limit.gradient(values, jacobian) for limit in workspace.limits], axis=1)
        D = by_state.reshape(NODES, -1, 3, n)
        parts = [D[:, :, k, :, None] * basis[:, None, None, :] for k, basis in enumerate(bases)]
        return parts[0] + parts[1] + parts[2]

    # which constraint depends on which joint: seen along three random motions
    rng = np.random.default_rng(SEED)
    nonzero = [np.abs(gradient(y)) > ZERO_DERIVATIVE for y in rng.standard_normal((3, n * m))]
    depends = np.any(nonzero, axis=(0, 1, 4))  # (R, n)
    pattern = np.broadcast_to(depends[None, :, :, None], (NODES, *depends.shape, m))
    entries = np.nonzero(pattern.reshape(NODES * len(depends), n * m))
    lower, upper = _bounds(workspace)
    return Constraints(
        np.tile(lower, NODES), np.tile(upper, NODES), np.column_stack(entries).astype(np.intp),
        value, lambda y: gradient(y)[pattern],
    )  # fmt: skip


def workspace_violation(workspace: Workspace, series: Series) -> Callable[[Array], Array]:
    """A function of P motions (P, n m): the sum (P, 1) of the largest violation at each instant, zero within all limits."""
    nodes = NODES // 2
    bases = series.basis(np.arange(nodes) / nodes)
    lower, upper = _bounds(workspace)

    def total(y: Array) -> Array:
        coefficients = y.reshape(len(y), series.n, series.m)
        x = np.concatenate([coefficients @ basis.T for basis in bases], axis=1)  # (P, 3 n, K)
        values = np.asarray(workspace.arm.functions[0].map(len(y) * nodes)(np.hstack(list(x)))).T
        g = np.concatenate([limit.constraint(values) for limit in workspace.limits], axis=1)
        beyond = np.maximum(lower - g, g - upper)
        return np.maximum(beyond.reshape(len(y), nodes, -1).max(axis=1), 0.0).sum(axis=1, keepdims=True)

    return total


def _bounds(workspace: Workspace) -> tuple[Array, Array]:
    """Lower and upper bounds (R,) of the constraints at one instant."""
    lower = [np.full(limit.count, limit.lower) for limit in workspace.limits]
    upper = [np.full(limit.count, limit.upper) for limit in workspace.limits]
    return np.concatenate(lower), np.concatenate(upper)
