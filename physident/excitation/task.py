"""What a design is for: whose columns, how weighted, on which motions."""

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
NODES = 48  # of a period: the tenth harmonic, which five of a joint make in its torque, has five of them
NODES_MEMORY = 192  # where an effect remembers: reversals are then an eighth of a second wide at most
CHECKED = 1000  # instants of a period for what is reported
TOGETHER = 8  # motions, of that many instants: more need more memory and are no faster
REFERENCE_MOTIONS = 4


@dataclass(frozen=True, eq=False)
class Task:
    """The columns to excite: of ``model`` with ``effects``, the ``chosen`` (r,), each times ``scale`` (r,), rows of each
    joint times ``weights`` (n,); ``weighting`` says in words where these come from."""

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
        """How many instants a period needs."""
        memory = any(not effect.pointwise for effect in self.effects)
        return max(NODES_MEMORY if memory else NODES, 8 * series.harmonics)

    def condition(self, series: Series, trajectory: Trajectory) -> float:
        """cond(Y) of the weighted columns over 1,000 instants of a period."""
        return self.conditions(series, series.numbers(trajectory)[None])[0]

    def conditions(self, series: Series, motions: Array) -> tuple[float, ...]:
        """cond(Y) as ``condition`` has it, of P motions by their free numbers (P, n m)."""
        information = self.information(series, CHECKED)
        parts = (information.stacks(motions[k : k + TOGETHER]) for k in range(0, len(motions), TOGETHER))
        return tuple(_condition(Y) for part in parts for Y in part)


def task_of(source: Robot | Model | Estimate) -> Task:
    """Excite everything that torques can show of a robot's rigid body, or of all effects of a model.

    An ``Estimate`` scales columns by the standard errors of its base parameters and rows by its residual; a ``Model``
    columns and rows by their size along random motions; a bare ``Robot`` nothing: cond(Y_B) as it is reported.
    """
    model = Model.nominal(source, ["rigid_body"]) if isinstance(source, Robot) else source
    if isinstance(model, Estimate):
        base, arm = model.base, model.model
        errors = np.sqrt(np.maximum(np.diag(model.covariance), 0.0))
        if not errors.any() or not model.sigma.any():
            raise InputError(
                "the model knows its parameters without error; expected one identified from data with noise, or --robot"
            )
        scale, noise = _positive(errors), _positive(model.sigma)
        return Task(arm, arm.effects, base.independent, scale, 1 / noise, "columns by standard error, rows by residual")
    base = find_base_parameters(model.robot, model.effects)
    n = model.robot.n
    plain = Task(model, model.effects, base.independent, np.ones(base.r), np.ones(n), "unscaled")
    if isinstance(source, Robot):
        return plain
    torque = np.mean([_torques(model, seed) for seed in range(REFERENCE_MOTIONS)], axis=0)
    weights = 1 / _positive(np.sqrt(torque))
    return sized(replace(plain, weights=weights, weighting="columns and rows by their size"))


def sized(task: Task) -> Task:
    """The task with columns scaled to unit size along random motions."""
    plain = replace(task, scale=np.ones(len(task.chosen)))
    size = np.sqrt(np.mean([_squares(plain, seed).sum(axis=1) for seed in range(REFERENCE_MOTIONS)], axis=0))
    return replace(task, scale=1 / _positive(size))


def _squares(task: Task, seed: int) -> Array:
    """Mean squares (r, n) of the columns along a random motion."""
    series = Series(task.model.robot.n, 5, 0.1)
    motion = random_trajectory(task.model.robot, seed, series.harmonics, series.base_frequency)
    return (task.information(series, 200).columns(series.numbers(motion)) ** 2).mean(axis=2)


def _torques(model: Model, seed: int) -> Array:
    motion = random_trajectory(model.robot, seed)
    states = motion.states(np.arange(200) / 200 * motion.duration)
    return (model.torque(replace(states, rate=200 / motion.duration)) ** 2).mean(axis=0)


def _condition(Y: Array) -> float:
    size = np.linalg.svd(Y, compute_uv=False)
    return float(size[0] / size[-1]) if size[-1] > 0 else float("inf")


def _positive(values: Array) -> Array:
    return np.maximum(values, 1e-9 * values.max()) if values.max() > 0 else np.ones_like(values)
