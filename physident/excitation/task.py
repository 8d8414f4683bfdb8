"""The task of a design: which columns of the regressor to excite, and how they are weighted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.effect import Effect
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.excitation.criterion.information import Information
from physident.excitation.motion.series import Series
from physident.excitation.motion.trajectory import Trajectory, random_trajectory
from physident.identifiability.base_parameters import find_base_parameters
from physident.robots.robot import Robot

Array = NDArray[np.float64]
NODES = 48  # instants of a period: five for each period of the torque's tenth harmonic
NODES_MEMORY = 192  # for effects with a memory: it resolves reversals to an eighth of a second
CHECKED = 1000  # instants of a period for the results that are reported
BATCH = 8  # motions evaluated together on that many instants: more need more memory and are no faster
REFERENCE_MOTIONS = 4  # random motions along which columns and rows are scaled
REFERENCE_NODES = 200  # instants of each
UNSCALED = "unscaled"  # the weighting of a bare robot's columns


@dataclass(frozen=True, eq=False)
class Task:
    """The columns to excite: the ``chosen`` (r,) of all ``effects``, which may be more than those of the ``model``.

    Each column is multiplied by its ``scale`` (r,), the rows of each joint by ``weights`` (n,). ``weighting`` describes in
    words where both come from.
    """

    model: Model
    effects: tuple[Effect, ...]
    chosen: NDArray[np.intp]
    scale: Array
    weights: Array
    weighting: str

    def information(self, series: Series, nodes: int) -> Information:
        """The information matrix on some instants of a period."""
        return Information(self.model, self.effects, series, nodes, self.chosen, self.scale, self.weights)

    def nodes(self, series: Series) -> int:
        """Number of instants that a period needs."""
        memory = any(not effect.pointwise for effect in self.effects)
        return max(NODES_MEMORY if memory else NODES, 8 * series.harmonics)

    def condition(self, series: Series, trajectory: Trajectory) -> float:
        """cond(Y) of the weighted columns over 1,000 instants of a period."""
        return self.conditions(series, series.numbers(trajectory)[None])[0]

    def conditions(self, series: Series, motions: Array) -> tuple[float, ...]:
        """The same of P motions by their free numbers (P, n m)."""
        information = self.information(series, CHECKED)
        parts = (information.regressors(motions[k : k + BATCH]) for k in range(0, len(motions), BATCH))
        return tuple(_condition(Y) for part in parts for Y in part)


def task_of(source: Robot | Model | Estimate) -> Task:
    """The base parameters of a robot's rigid body, or of all effects of a model, as the columns to excite.

    Learned curves are left to ``design_covering``: they have a prior, and need no motion that shows all their numbers. For an
    ``Estimate``, columns are scaled by the standard errors of its base parameters and rows by its residual. For a
    ``Model``, both are scaled by their size along random motions. A bare ``Robot`` is not scaled, so that the condition
    number is that of the base regressor Y_B. Raises InputError for an estimate without standard errors.
    """
    model = Model.nominal(source, ["rigid_body"]) if isinstance(source, Robot) else source
    if isinstance(model, Estimate):
        base, arm = model.base, model.model
        errors = np.sqrt(np.maximum(np.diag(model.covariance), 0.0))
        if not errors.any() or not model.sigma.any():
            raise InputError(
                "the model's parameters have no standard errors; expected a model identified from data with noise, or --robot"
            )
        laws = _of_laws(arm, base.independent)
        scale, noise = _positive(errors[laws]), _positive(model.sigma)
        return Task(
            arm, arm.effects, base.independent[laws], scale, 1 / noise, "columns by standard error, rows by residual"
        )
    base = find_base_parameters(model.robot, model.effects)
    n = model.robot.n
    chosen = base.independent[_of_laws(model, base.independent)]
    unscaled = Task(model, model.effects, chosen, np.ones(len(chosen)), np.ones(n), UNSCALED)
    if isinstance(source, Robot):
        return unscaled
    torque = np.mean([_torques(model, seed) for seed in range(REFERENCE_MOTIONS)], axis=0)
    weights = 1 / _positive(np.sqrt(torque))
    return scaled_to_unit_size(replace(unscaled, weights=weights, weighting="columns and rows by their size"))


def _of_laws(model: Model, columns: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Which of some columns belong to effects without a prior."""
    held = np.array([effect.has_prior for effect in model.effects for _ in effect.columns(model.robot)], dtype=bool)
    return ~held[columns]


def scaled_to_unit_size(task: Task) -> Task:
    """The task with columns scaled to unit size along random motions."""
    unscaled = replace(task, scale=np.ones(len(task.chosen)))
    size = np.sqrt(np.mean([_squares(unscaled, seed).sum(axis=1) for seed in range(REFERENCE_MOTIONS)], axis=0))
    return replace(task, scale=1 / _positive(size))


def _squares(task: Task, seed: int) -> Array:
    """Mean squares (r, n) of the columns along a random motion."""
    series = Series(task.model.robot.n, 5, 0.1)
    motion = random_trajectory(task.model.robot, seed, series.harmonics, series.base_frequency)
    return (task.information(series, REFERENCE_NODES).weighted_columns(series.numbers(motion)) ** 2).mean(axis=2)


def _torques(model: Model, seed: int) -> Array:
    """Mean squares (n,) of the torque along a random motion."""
    motion = random_trajectory(model.robot, seed)
    states = motion.states(np.arange(REFERENCE_NODES) / REFERENCE_NODES * motion.duration)
    return (model.torque(replace(states, rate=REFERENCE_NODES / motion.duration)) ** 2).mean(axis=0)


def _condition(Y: Array) -> float:
    size = np.linalg.svd(Y, compute_uv=False)
    return float(size[0] / size[-1]) if size[-1] > 0 else float("inf")


def _positive(values: Array) -> Array:
    return np.maximum(values, 1e-9 * values.max()) if values.max() > 0 else np.ones_like(values)
