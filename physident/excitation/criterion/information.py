"""The information matrix of a motion, and how it moves with the motion's free numbers.

Rigid-body columns are differentiated exactly, by the reverse mode of their CasADi expression. All other effects only need
to give values: each sample's are differenced over its own state, those with a memory over the free numbers of the motion.
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
from physident.effects.rigid_body import RigidBody
from physident.excitation.motion.series import Series
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
STEP = 1e-6  # of a state's unit: rounding and curvature then both stay below 1e-8 of a column


@dataclass(frozen=True, eq=False)
class Information:
    """Weighted regressor columns of a motion on K instants of its period.

    ``model`` gives the columns that depend on its torque; ``effects`` may be more than the model's own. Of all columns
    the ``chosen`` (r,) count, each times its ``scale`` (r,); ``weights`` (n,) multiply the rows of each joint.
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
    def _last(self) -> dict[bytes, Array]:
        return {}

    @cached_property
    def bases(self) -> tuple[Array, Array, Array]:
        """Q, V, A (K, m) of ``Series.basis`` on the nodes."""
        return self.series.basis(np.arange(self.nodes) / self.nodes)

    def matrix(self, y: Array) -> Array:
        """G (r, r) of free numbers (n m,)."""
        Z = self.columns(y).reshape(len(self.chosen), -1)
        return Z @ Z.T

    def stacked(self, y: Array) -> Array:
        """The weighted regressor (n K, r) of free numbers (n m,)."""
        return self.columns(y).reshape(len(self.chosen), -1).T

    def stacks(self, y: Array) -> Array:
        """The weighted regressors (P, n K, r) of P motions (P, n m)."""
        q, v, a = (x.reshape(-1, self.series.n) for x in self.states(y))
        return np.swapaxes(self._columns(q, v, a, len(y)).reshape(len(y), len(self.chosen), -1), 1, 2)

    def matrices(self, y: Array) -> Array:
        """G (P, r, r) of P motions (P, n m)."""
        Y = self.stacks(y)
        return np.swapaxes(Y, 1, 2) @ Y

    def pullback(self, y: Array, slope: Array) -> Array:
        """Gradient (n m,) of a function of G whose symmetric gradient at ``y`` is ``slope`` (r, r)."""
        q, v, a = self.states(y)
        bar = 2 * np.tensordot(slope, self.columns(y), 1)  # (r, n, K)
        by_state = np.zeros((3, self.series.n, self.nodes))
        result = np.zeros(y.size)
        moved: dict[bool, Signals] = {}
        for effect, own in zip(self.effects, self._places, strict=True):
            if not len(own.kept):
                continue
            entries = bar[own.column, own.row] * own.factor[:, None]
            if isinstance(effect, RigidBody):
                by_state += self._rigid_pullback(q, v, a, own, entries)
            elif effect.pointwise:
                if effect.needs_model not in moved:
                    moved[effect.needs_model] = self._moved(q, v, a, effect.needs_model)
                slopes = self._by_state(effect, own, moved[effect.needs_model])
                by_state += np.einsum("ek,esk->sk", entries, slopes).reshape(by_state.shape)
            else:
                result += np.einsum("ek,yek->y", entries, self._by_number(effect, own, y))
        for s, basis in zip(by_state, self.bases, strict=True):
            result += (s @ basis).ravel()
        return result

    def columns(self, y: Array) -> Array:
        """Weighted columns (r, n, K) of one motion; the last one is remembered, which its gradient needs again."""
        key = y.tobytes()
        if key not in self._last:
            self._last.clear()
            self._last[key] = self._columns(*self.states(y), 1)[0]
        return self._last[key]

    def _columns(self, q: Array, v: Array, a: Array, motions: int) -> Array:
        """Weighted columns (motions, r, n, K) of states (motions K, n)."""
        n, K = self.series.n, len(q) // motions
        Z = np.zeros((len(self.chosen), n, len(q)))
        signals = None
        for effect, own in zip(self.effects, self._places, strict=True):
            if not len(own.kept):
                continue
            if isinstance(effect, RigidBody):
                values = self._entries(q, v, a) if motions == 1 else torque_entries(self.model.robot, q, v, a)
            else:
                signals = signals or self._signals(q, v, a, motions, self._needs_model)
                values = self._values(effect, signals, motions)
            Z[own.column, own.row] += values[own.kept] * own.factor[:, None]
        return np.moveaxis(Z.reshape(len(self.chosen), n, motions, K), 2, 0)

    def _signals(self, q: Array, v: Array, a: Array, motions: int, referred: bool) -> Signals:
        """States of several motions one after another, each from time zero on, ``referred`` to the model where asked."""
        K = len(q) // motions
        rate = K / self.series.period
        time = np.tile(np.arange(K) / rate, motions)
        memory = any(not effect.pointwise for effect in self.model.effects)
        starts = tuple(range(0, len(q), K)) if memory else (0,)  # a segment each only where it matters: they take time
        signals = Signals(time, q, v, a, rate=rate, starts=starts, source="a planned motion")
        return self.model.refer(signals) if referred else signals

    def _values(self, effect: Effect, signals: Signals, motions: int) -> Array:
        """Values (E, motions K) of an effect; one with a memory begins anew with each motion."""
        robot = self.model.robot
        if effect.pointwise:
            return effect.values(robot, signals)
        K = len(signals.time) // motions
        parts = (signals.part(slice(k * K, (k + 1) * K)) for k in range(motions))
        return np.concatenate([effect.values(robot, part) for part in parts], axis=1)

    def _moved(self, q: Array, v: Array, a: Array, referred: bool) -> Signals:
        """The motion with each number of the state moved up and then down: 6 n motions."""
        n = self.series.n
        states = np.tile(np.concatenate([q, v, a], axis=1), (6 * n, 1, 1))
        for s in range(3 * n):
            states[s, :, s] += STEP
            states[3 * n + s, :, s] -= STEP
        q, v, a = (x.reshape(-1, n) for x in np.split(states, 3, axis=2))
        return self._signals(q, v, a, 6 * n, referred)

    def _by_state(self, effect: Effect, own: _Place, moved: Signals) -> Array:
        """Derivatives (E, 3 n, K) of an effect's kept values by its sample's own state."""
        values = effect.values(self.model.robot, moved)[own.kept].reshape(-1, 2, 3 * self.series.n, self.nodes)
        return (values[:, 0] - values[:, 1]) / (2 * STEP)

    def _by_number(self, effect: Effect, own: _Place, y: Array) -> Array:
        """Derivatives (n m, E, K) of an effect's kept values by the motion's free numbers."""
        moved = np.concatenate([y + STEP * np.eye(y.size), y - STEP * np.eye(y.size)])
        q, v, a = (x.reshape(-1, self.series.n) for x in self.states(moved))
        signals = self._signals(q, v, a, len(moved), effect.needs_model)
        values = self._values(effect, signals, len(moved))[own.kept]
        up, down = np.moveaxis(values.reshape(len(own.kept), 2, y.size, self.nodes), (1, 2), (0, 1))
        return (up - down) / (2 * STEP)

    def _rigid_pullback(self, q: Array, v: Array, a: Array, own: _Place, entries: Array) -> Array:
        bar = np.zeros((len(torque_pattern(self.model.robot)), self.nodes))
        bar[own.kept] = entries
        return np.asarray(self._programs[1](np.hstack([q, v, a]).T, bar)).reshape(3, self.series.n, self.nodes)

    def _entries(self, q: Array, v: Array, a: Array) -> Array:
        return np.asarray(self._programs[0](np.hstack([q, v, a]).T))

    @cached_property
    def _programs(self) -> tuple[Any, Any]:
        """CasADi functions over all nodes: states -> entries, and (states, bar) -> gradient of sum bar * entries."""
        import casadi as ca

        n = self.series.n
        x = ca.SX.sym("x", 3 * n)
        entries = ca.vertcat(*torque_expression(self.model.robot)(*ca.vertsplit(x, n)).nonzeros())
        bar = ca.SX.sym("bar", entries.shape[0])
        adjoint = ca.Function("adjoint", [x, bar], [ca.jtimes(entries, x, bar, True)])
        return ca.Function("entries", [x], [entries]).map(self.nodes), adjoint.map(self.nodes)

    @cached_property
    def _needs_model(self) -> bool:
        return any(effect.needs_model for effect in self.effects)

    @cached_property
    def _places(self) -> list[_Place]:
        """For each effect which of its structural non-zeros are in chosen columns, and where."""
        robot, at, places = self.model.robot, 0, []
        position = {int(c): k for k, c in enumerate(self.chosen)}
        for effect in self.effects:
            pattern = torque_pattern(robot) if isinstance(effect, RigidBody) else effect.pattern(robot)
            kept = np.array([e for e, (_, c) in enumerate(pattern) if at + c in position], dtype=np.intp)
            row = pattern[kept, 0] if len(kept) else kept
            column = np.array([position[int(at + c)] for c in pattern[kept, 1]], dtype=np.intp) if len(kept) else kept
            places.append(_Place(kept, row, column, self.weights[row] * self.scale[column]))
            at += len(effect.columns(robot))
        return places


@dataclass(frozen=True, eq=False)
class _Place:
    """Which entries (E,) of an effect count, their joint ``row``, ``column`` among the chosen, and weight ``factor``."""

    kept: NDArray[np.intp]
    row: NDArray[np.intp]
    column: NDArray[np.intp]
    factor: Array
