"""The information matrix of a motion, and its derivatives by the motion's free numbers.

Rigid-body columns are differentiated exactly, by the reverse mode of their CasADi expression. All other effects provide
values only. Pointwise effects are differenced over the state of each sample, effects with a memory over the free numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.rigid_body_regressor import torque_entries, torque_expression, torque_pattern
from physident.effects.effect import Effect
from physident.effects.inertia import RigidBody
from physident.excitation.motion.series import Series
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
STEP = 1e-6  # of differences, in the state's unit: rounding and curvature are both below 1e-8 of a column


@dataclass(frozen=True, eq=False)
class Information:
    """Weighted regressor of a motion on K = ``nodes`` instants of its period.

    ``effects`` may be more than those of the ``model``, whose torque some of them depend on. Of all columns the ``chosen``
    (r,) count, each times its ``scale`` (r,); ``weights`` (n,) multiply the rows of each joint.
    """

    model: Model
    effects: tuple[Effect, ...]
    series: Series
    nodes: int
    chosen: NDArray[np.intp]
    scale: Array
    weights: Array

    def states(self, y: Array) -> tuple[Array, Array, Array]:
        """q, v, a (..., K, n) of free numbers (..., n m)."""
        rows = y.reshape(*y.shape[:-1], self.series.n, self.series.m)
        return tuple(np.swapaxes(rows @ basis.T, -1, -2) for basis in self.bases)  # pyright: ignore[reportReturnType]

    @cached_property
    def bases(self) -> tuple[Array, Array, Array]:
        """Q, V, A (K, m) of ``Series.basis`` on the nodes."""
        return self.series.basis(np.arange(self.nodes) / self.nodes)

    def matrix(self, y: Array) -> Array:
        """G (r, r) of free numbers (n m,)."""
        Z = self.weighted_columns(y).reshape(len(self.chosen), -1)
        return Z @ Z.T

    def regressor(self, y: Array) -> Array:
        """The weighted regressor (n K, r) of free numbers (n m,)."""
        return self.weighted_columns(y).reshape(len(self.chosen), -1).T

    def regressors(self, y: Array) -> Array:
        """The weighted regressors (P, n K, r) of P motions (P, n m)."""
        q, v, a = (x.reshape(-1, self.series.n) for x in self.states(y))
        return np.swapaxes(self._evaluate(q, v, a, len(y)).reshape(len(y), len(self.chosen), -1), 1, 2)

    def matrices(self, y: Array) -> Array:
        """G (P, r, r) of P motions (P, n m)."""
        Y = self.regressors(y)
        return np.swapaxes(Y, 1, 2) @ Y

    def pullback(self, y: Array, slope: Array) -> Array:
        """Gradient (n m,) of a function of G whose symmetric gradient at ``y`` is ``slope`` (r, r)."""
        q, v, a = self.states(y)
        adjoint = 2 * np.tensordot(slope, self.weighted_columns(y), 1)  # (r, n, K)
        by_state = np.zeros((3, self.series.n, self.nodes))
        result = np.zeros(y.size)
        shifted: dict[bool, Signals] = {}
        for effect, entries in zip(self.effects, self._entries, strict=True):
            if not len(entries.kept):
                continue
            weighted = adjoint[entries.column, entries.row] * entries.factor[:, None]
            if isinstance(effect, RigidBody):
                by_state += self._rigid_body_pullback(q, v, a, entries, weighted)
            elif effect.pointwise:
                if effect.needs_model not in shifted:
                    shifted[effect.needs_model] = self._shifted_states(q, v, a, effect.needs_model)
                slopes = self._derivatives_by_state(effect, entries, shifted[effect.needs_model])
                by_state += np.einsum("ek,esk->sk", weighted, slopes).reshape(by_state.shape)
            else:
                result += np.einsum("ek,yek->y", weighted, self._derivatives_by_number(effect, entries, y))
        for s, basis in zip(by_state, self.bases, strict=True):
            result += (s @ basis).ravel()
        return result

    def weighted_columns(self, y: Array) -> Array:
        """Weighted columns (r, n, K) of one motion; the latest result is cached, because its gradient needs it again."""
        key = y.tobytes()
        if key not in self._latest:
            self._latest.clear()
            self._latest[key] = self._evaluate(*self.states(y), 1)[0]
        return self._latest[key]

    @cached_property
    def _latest(self) -> dict[bytes, Array]:
        return {}

    def _evaluate(self, q: Array, v: Array, a: Array, motions: int) -> Array:
        """Weighted columns (motions, r, n, K) of states (motions K, n)."""
        n, K = self.series.n, len(q) // motions
        Z = np.zeros((len(self.chosen), n, len(q)))
        signals = None
        for effect, entries in zip(self.effects, self._entries, strict=True):
            if not len(entries.kept):
                continue
            if isinstance(effect, RigidBody):
                values = self._rigid_body(q, v, a) if motions == 1 else torque_entries(self.model.robot, q, v, a)
            else:
                signals = signals or self._signals(q, v, a, motions, self._needs_model)
                values = self._values(effect, signals, motions)
            Z[entries.column, entries.row] += values[entries.kept] * entries.factor[:, None]
        return np.moveaxis(Z.reshape(len(self.chosen), n, motions, K), 2, 0)

    def _signals(self, q: Array, v: Array, a: Array, motions: int, needs_model: bool) -> Signals:
        """States of several motions in sequence, each starting at time zero, with the model's torque where needed."""
        K = len(q) // motions
        rate = K / self.series.period
        time = np.tile(np.arange(K) / rate, motions)
        memory = any(not effect.pointwise for effect in self.model.effects)
        starts = tuple(range(0, len(q), K)) if memory else (0,)  # segments cost time: only for effects with a memory
        signals = Signals(time, q, v, a, rate=rate, starts=starts, source="a planned motion")
        return self.model.refer(signals) if needs_model else signals

    def _values(self, effect: Effect, signals: Signals, motions: int) -> Array:
        """Values (E, motions K) of an effect; the memory of an effect restarts with each motion."""
        robot = self.model.robot
        if effect.pointwise:
            return effect.values(robot, signals)
        K = len(signals.time) // motions
        parts = (signals.part(slice(k * K, (k + 1) * K)) for k in range(motions))
        return np.concatenate([effect.values(robot, part) for part in parts], axis=1)

    def _shifted_states(self, q: Array, v: Array, a: Array, needs_model: bool) -> Signals:
        """The motion with each component of the state shifted up, then each shifted down: 6 n motions."""
        n = self.series.n
        states = np.tile(np.concatenate([q, v, a], axis=1), (6 * n, 1, 1))
        for s in range(3 * n):
            states[s, :, s] += STEP
            states[3 * n + s, :, s] -= STEP
        q, v, a = (x.reshape(-1, n) for x in np.split(states, 3, axis=2))
        return self._signals(q, v, a, 6 * n, needs_model)

    def _derivatives_by_state(self, effect: Effect, entries: _Entries, shifted: Signals) -> Array:
        """Derivatives (E, 3 n, K) of an effect's kept values by the state of the same sample."""
        values = effect.values(self.model.robot, shifted)[entries.kept]
        values = values.reshape(-1, 2, 3 * self.series.n, self.nodes)
        return (values[:, 0] - values[:, 1]) / (2 * STEP)

    def _derivatives_by_number(self, effect: Effect, entries: _Entries, y: Array) -> Array:
        """Derivatives (n m, E, K) of an effect's kept values by the motion's free numbers."""
        shifted = np.concatenate([y + STEP * np.eye(y.size), y - STEP * np.eye(y.size)])
        q, v, a = (x.reshape(-1, self.series.n) for x in self.states(shifted))
        signals = self._signals(q, v, a, len(shifted), effect.needs_model)
        values = self._values(effect, signals, len(shifted))[entries.kept]
        up, down = np.moveaxis(values.reshape(len(entries.kept), 2, y.size, self.nodes), (1, 2), (0, 1))
        return (up - down) / (2 * STEP)

    def _rigid_body(self, q: Array, v: Array, a: Array) -> Array:
        return np.asarray(self._programs[0](np.hstack([q, v, a]).T))

    def _rigid_body_pullback(self, q: Array, v: Array, a: Array, entries: _Entries, weighted: Array) -> Array:
        adjoint = np.zeros((len(torque_pattern(self.model.robot)), self.nodes))
        adjoint[entries.kept] = weighted
        return np.asarray(self._programs[1](np.hstack([q, v, a]).T, adjoint)).reshape(3, self.series.n, self.nodes)

    @cached_property
    def _programs(self) -> tuple[Any, Any]:
        """CasADi functions over all nodes: states -> entries, and (states, adjoint) -> gradient of sum adjoint * entries."""
        import casadi as ca

        n = self.series.n
        x = ca.SX.sym("x", 3 * n)
        entries = ca.vertcat(*torque_expression(self.model.robot)(*ca.vertsplit(x, n)).nonzeros())
        adjoint = ca.SX.sym("adjoint", entries.shape[0])
        gradient = ca.Function("gradient", [x, adjoint], [ca.jtimes(entries, x, adjoint, True)])
        return ca.Function("entries", [x], [entries]).map(self.nodes), gradient.map(self.nodes)

    @cached_property
    def _needs_model(self) -> bool:
        return any(effect.needs_model for effect in self.effects)

    @cached_property
    def _entries(self) -> list[_Entries]:
        """For each effect, the structural non-zeros that lie in chosen columns."""
        robot, start, result = self.model.robot, 0, []
        position = {int(c): k for k, c in enumerate(self.chosen)}
        for effect in self.effects:
            pattern = torque_pattern(robot) if isinstance(effect, RigidBody) else effect.pattern(robot)
            kept = np.array([e for e, (_, c) in enumerate(pattern) if start + c in position], dtype=np.intp)
            row = pattern[kept, 0] if len(kept) else kept
            column = (
                np.array([position[int(start + c)] for _, c in pattern[kept]], dtype=np.intp) if len(kept) else kept
            )
            result.append(_Entries(kept, row, column, self.weights[row] * self.scale[column]))
            start += len(effect.columns(robot))
        return result


@dataclass(frozen=True, eq=False)
class _Entries:
    """Structural non-zeros (E,) of an effect: indices of those ``kept``, their joint ``row``, their ``column`` among the
    chosen ones, and their weight ``factor``."""

    kept: NDArray[np.intp]
    row: NDArray[np.intp]
    column: NDArray[np.intp]
    factor: Array
