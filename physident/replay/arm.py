"""A model's equations of motion for many states at once: inertia matrix, bias torque and all other effects."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.inverse_dynamics import torque_function
from physident.dynamics.model import Model
from physident.dynamics.vectorised import Vectorised
from physident.recordings.signals import Signals
from physident.simulation.plant import Instants, Plant

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Arm:
    """The simulated arm of a model with n joints, for N states (N, n) at once.

    Effects of the torque measurement are no part of it; those of the encoders are: states are those of the true arm.
    """

    model: Model

    @cached_property
    def plant(self) -> Plant:
        """Effects other than inertia, see ``Plant``."""
        return Plant(self.model)

    @cached_property
    def _dynamics(self) -> Vectorised:
        import casadi as ca

        robot, inertia = self.model.robot, self.model.added_inertia()
        x, y, z = np.array(robot.gravity) + inertia.gravity
        heavy = replace(robot, gravity=(float(x), float(y), float(z)))
        q, v, a, links = (
            ca.SX.sym(name, size) for name, size in zip("qval", (robot.n,) * 3 + (10 * robot.n,), strict=True)
        )
        tau = torque_function(heavy)(q, v, a, links)
        M = ca.densify(ca.jacobian(tau, a))
        bias = torque_function(heavy)(q, v, 0, links)
        return Vectorised(ca.Function("dynamics", [ca.vertcat(q, v), links], [ca.densify(ca.vertcat(ca.vec(M), bias))]))

    def dynamics(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Inertia matrices (N, n, n) [kg m^2|kg], armature included, and bias torques (N, n) [N m|N] of gravity and motion."""
        n, inertia = self.model.robot.n, self.model.added_inertia()
        values = self._dynamics.run(np.concatenate([q.T, v.T]), inertia.links).T
        M = values[:, : n * n].reshape(-1, n, n).transpose(0, 2, 1) + np.diag(inertia.armature)
        return M, values[:, n * n :]

    def measured(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Positions and velocities (N, n) that the encoders show of true ones."""
        shown = Signals(np.zeros(len(q)), q, v, np.zeros_like(q), np.zeros_like(q))
        for effect, theta in self.model.effect_parameters():
            if effect.acts_on == "sensor":
                shown = effect.measure(self.model.robot, theta, shown)
        return shown.q, shown.v

    def true(self, q: Array, v: Array) -> tuple[Array, Array]:
        """True positions and velocities (N, n) behind those that the encoders show, to first order."""
        shown_q, shown_v = self.measured(q, v)
        return 2 * q - shown_q, 2 * v - shown_v

    def advanced(self, at: Instants, step: float) -> Array:
        """Internal states (S, N) of the effects after a step [s] at constant velocities: exact for rates linear in them."""
        if not self.plant.states:
            return at.state
        still = self.plant.state_rate(replace(at, state=np.zeros_like(at.state)))
        slope = self.plant.state_rate(replace(at, state=np.ones_like(at.state))) - still
        # dz/dt = still + slope z over a step; (exp(x) - 1) / x is one where the slope is zero
        x = slope * step
        gain = np.where(np.abs(x) > 1e-12, np.expm1(x) / np.where(np.abs(x) > 1e-12, x, 1.0), 1.0)
        return at.state * np.exp(x) + still * step * gain
