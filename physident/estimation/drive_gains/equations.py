"""The equations K_j i_j = Y_j theta + (load) that tie drive gains, arm and a load of known mass together.

Unknown are x (q,), the arm's base parameters and the load's nine other than its mass, and the gains K (n,). What is
measured with error is the current, and K multiplies it: with plain least squares that error pulls every gain down.
Here a row's error is that of its current, i_j - f_j(x) / K_j with f the modelled torque, over the noise s_j of joint j:
total least squares with the structure kept. Gauss-Newton in log K then multiplies K by the modelled torque, never by
the measured one. Every iteration works on one small QR factor for each joint.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import JointRows, Regressor
from physident.effects.effect import Column
from physident.errors import NotSolvedError, warn
from physident.estimation.payload.load_regressor import all_independent, load_regressor
from physident.estimation.uncertainty import BLOCK_PERIODS, FEWEST_BLOCKS, SHORTEST_PERIODS, correlation_rows, jackknife
from physident.identifiability.base_parameters import BaseParameters

Array = NDArray[np.float64]
MAX_ITERATIONS = 100
SETTLED = 1e-8  # largest change of a gain's logarithm
LONGEST_STEP = 0.7  # of a gain's logarithm: a factor of two
RANK_TOLERANCE = 1e-8  # of the largest singular value, columns scaled to unit length
SHARE = 1e-3  # of an undetermined direction: with a larger share, a gain is part of it


@dataclass(frozen=True, eq=False)
class GainSolution:
    """``x`` (q,) parameters of arm and load, ``gains`` (n,) [N m/A], ``noise`` (n,) [A] of each joint's current, ``load``
    (10,); ``total``: whether the errors were attributed to the currents (total least squares) or to the torques."""

    x: Array
    gains: Array
    noise: Array
    load: Array
    total: bool = True


@dataclass(frozen=True, eq=False)
class _Joint:
    """One joint's columns among x (k,), their rows and those of known torque and current, and the factor of all."""

    columns: NDArray[np.intp]
    values: Array
    known: Array
    current: Array
    factor: Array


class GainEquations:
    """The equations of recordings whose ``regressor`` has currents [A] for torques; ``loaded`` (M,) rows carry the load."""

    def __init__(self, regressor: Regressor, base: BaseParameters, loaded: NDArray[np.bool_], mass: float) -> None:
        self.regressor, self.base, self.mass = regressor, base, mass
        self.carried, self.carrying = loaded, int(np.count_nonzero(loaded))
        self.size = base.r + 9
        load = load_regressor(regressor, regressor.torque, loaded)
        place = np.full(len(regressor.columns), -1)
        place[base.independent] = np.arange(base.r)
        self.joints = tuple(
            _joint(arm, carried, current, place, base.r, mass)
            for arm, carried, current in zip(regressor.joints, load.joints, regressor.torque.T, strict=True)
        )

    @property
    def load_felt(self) -> bool:
        """Whether the known mass exerts a torque on some joint."""
        return any(np.linalg.norm(j.known) > 1e-9 * np.linalg.norm(j.values) for j in self.joints)

    def total_least_squares(self) -> GainSolution:
        """The gains with the smallest errors of the currents; raises NotSolvedError where the iteration does not settle."""
        solution = self._start()
        for _ in range(MAX_ITERATIONS):
            A, b = self.linearised(solution)
            scale = np.linalg.norm(A, axis=0)
            scale = np.where(scale > 0, scale, 1.0)
            U, singular, Vt = np.linalg.svd(A / scale, full_matrices=False)
            kept = singular > RANK_TOLERANCE * singular[0]
            step = Vt[kept].T @ ((U[:, kept].T @ b) / singular[kept]) / scale
            step *= min(1.0, LONGEST_STEP / max(1e-300, float(np.abs(step[self.size :]).max())))
            solution = self.after_step(solution, step)
            if np.abs(step[self.size :]).max() < SETTLED:
                return solution
        raise NotSolvedError(
            f"drive gains did not settle in {MAX_ITERATIONS} iterations; use recordings in which the load moves more, or check its mass"
        )

    def least_squares(self) -> GainSolution:
        """Gains that minimise the torque's error, each joint weighted by its residual: biased low, for comparison."""
        plain = self._linear(np.ones(len(self.joints)))
        return self._linear(1 / np.maximum(plain.noise * np.abs(plain.gains), 1e-12))

    def linearised(self, solution: GainSolution) -> tuple[Array, Array]:
        """A (m, q + n) and b (m,) of the step (dx, -d log K) around a solution, in units of each joint's noise."""
        rows, target = [], []
        for j, (joint, gain, s) in enumerate(zip(self.joints, solution.gains, solution.noise, strict=True)):
            F, x = joint.factor, solution.x[joint.columns]
            A = np.zeros((len(F), self.size + len(self.joints)))
            torque = F[:, :-2] @ x + F[:, -2]
            A[:, joint.columns], A[:, self.size + j] = F[:, :-2] / (gain * s), torque / (gain * s)
            rows.append(A)
            target.append((F[:, -1] - torque / gain) / s)
        return np.concatenate(rows), np.concatenate(target)

    def after_step(self, solution: GainSolution, step: Array) -> GainSolution:
        """The solution after a step (dx, -d log K), with its residual as the new noise."""
        x, gains = solution.x + step[: self.size], solution.gains * np.exp(-step[self.size :])
        return self._with_noise(replace(solution, x=x, gains=gains, load=self._load(x)))

    def _with_noise(self, solution: GainSolution) -> GainSolution:
        """The solution with the size of its residual as noise."""
        noise = [self._error(j, solution.x, k) for j, k in zip(self.joints, solution.gains, strict=True)]
        return replace(solution, noise=np.array(noise))

    def decided(self, solution: GainSolution) -> NDArray[np.bool_]:
        """Which gains (n,) the equations determine; the others are part of an undetermined direction."""
        A, _ = self.linearised(solution)
        scale = np.linalg.norm(A, axis=0)
        scale = np.where(scale > 0, scale, 1.0)
        _, singular, Vt = np.linalg.svd(A / scale)
        open_directions = Vt[np.count_nonzero(singular > RANK_TOLERANCE * singular[0]) :, self.size :]
        return np.abs(open_directions).max(axis=0, initial=0.0) < SHARE

    def unexplained(self, solution: GainSolution) -> Array:
        """Share (n,) [%] of each joint's current that the model does not explain."""
        size = np.array([np.sqrt((joint.current**2).mean()) for joint in self.joints])
        return 100 * self._with_noise(solution).noise / np.where(size > 0, size, 1.0)

    def log_covariance(self, solution: GainSolution) -> tuple[Array, int]:
        """Covariance (n, n) of log K, valid for autocorrelated errors, and the number of blocks behind it.

        The scale comes from the rows with the load alone, so only their blocks count.
        """
        n, M = len(self.joints), len(self.regressor.time)
        rows, residual = [], np.zeros((M, n))
        for j, (joint, gain, s) in enumerate(zip(self.joints, solution.gains, solution.noise, strict=True)):
            torque = joint.values @ solution.x[joint.columns] + joint.known
            multiplied = torque if solution.total else gain * joint.current
            values = np.column_stack([joint.values, multiplied]) / (gain * s)
            rows.append(JointRows(np.append(joint.columns, self.size + j), values))
            residual[:, j] = (joint.current - torque / gain) / s
        names = tuple(Column(f"x_{i}", "-", 0, "") for i in range(self.size + n))
        white = replace(self.regressor, columns=names, joints=tuple(rows), torque=residual)
        memory = float(correlation_rows(white, residual).max())
        self._warn_if_short(memory)
        shorter = min(memory, max(1, self.carrying // FEWEST_BLOCKS) / BLOCK_PERIODS)
        cut = jackknife(white, all_independent(names), residual, shorter)
        blocks = max(2, round(self.carrying / max(1.0, BLOCK_PERIODS * shorter)))
        return cut.covariance[self.size :, self.size :], blocks

    def _warn_if_short(self, memory: float) -> None:
        if self.carrying < FEWEST_BLOCKS * SHORTEST_PERIODS * memory:
            seconds = self.carrying / self.regressor.kept_rate
            warn(
                f"{seconds:.3g} s of motion with the load contain {self.carrying / memory:.0f} independent samples: intervals of drive gains are rough; record the load longer"
            )

    def _linear(self, weights: Array) -> GainSolution:
        """The least-squares solution with ``weights`` (n,) of the joints' torque."""
        rows, target = [], []
        for j, (joint, w) in enumerate(zip(self.joints, weights, strict=True)):
            A = np.zeros((len(joint.factor), self.size + len(self.joints)))
            A[:, joint.columns], A[:, self.size + j] = joint.factor[:, :-2], -joint.factor[:, -1]
            rows.append(w * A)
            target.append(-w * joint.factor[:, -2])
        found = np.linalg.lstsq(np.concatenate(rows), np.concatenate(target), rcond=RANK_TOLERANCE)[0]
        x, gains = found[: self.size], found[self.size :]
        return self._with_noise(GainSolution(x, gains, np.ones(len(gains)), self._load(x), total=False))

    def _start(self) -> GainSolution:
        """One gain for all joints, such that the load has its known mass."""
        n = len(self.joints)
        rows, target = [], []
        for joint in self.joints:
            A = np.zeros((len(joint.factor), self.size + 1))
            A[:, joint.columns], A[:, -1] = joint.factor[:, :-2], joint.factor[:, -2]
            weight = 1 / max(float(np.linalg.norm(joint.current)), 1e-300)
            rows.append(weight * A)
            target.append(weight * joint.factor[:, -1])
        found = np.linalg.lstsq(np.concatenate(rows), np.concatenate(target), rcond=RANK_TOLERANCE)[0]
        gain = 1 / max(abs(float(found[-1])), 1e-6)
        x, gains = gain * found[:-1], np.full(n, gain)
        return self._with_noise(GainSolution(x, gains, np.ones(n), self._load(x)))

    def _error(self, joint: _Joint, x: Array, gain: float) -> float:
        """Standard deviation of the current's error [A]."""
        error = joint.factor @ np.concatenate([x[joint.columns] / gain, [1 / gain, -1.0]])
        floor = 1e-9 * float(np.linalg.norm(joint.factor[:, -1]))  # noise-free currents must not divide by zero
        return max(float(np.linalg.norm(error)), floor, 1e-300) / np.sqrt(len(joint.current))

    def _load(self, x: Array) -> Array:
        return np.concatenate([[self.mass], x[self.base.r :]])


def _joint(arm: JointRows, load: JointRows, current: Array, place: Array, r: int, mass: float) -> _Joint:
    seen = place[arm.columns] >= 0
    is_mass = load.columns == 0
    columns = np.concatenate([place[arm.columns[seen]], r - 1 + load.columns[~is_mass]]).astype(np.intp)
    values = np.column_stack([arm.values[:, seen], load.values[:, ~is_mass]])
    known = mass * load.values[:, is_mass].sum(axis=1)
    factor = np.asarray(np.linalg.qr(np.column_stack([values, known, current]), mode="r"))
    return _Joint(columns, values, known, np.ascontiguousarray(current), factor)
