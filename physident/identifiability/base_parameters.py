"""Base parameters: the combinations of parameters that torques depend on, found by a rank-revealing QR."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.effect import Column, Effect
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
TOLERANCE = 1e-7  # share of a column's length outside the accepted columns, below which it depends on them
ZERO = 1e-9  # of the effect's largest column: a smaller column is rounding
STATES = 400
WIDTH = 100  # characters of a printed line
RATE = 20.0  # Hz
HELD = 1e-4  # share of what is left of a sum that goes to what the nominal values state, beside what they do not
EXPRESSION_FLOOR = 1e-9  # a coefficient of beta below this is rounding


@dataclass(frozen=True, eq=False)
class BaseParameters:
    """Which r of p parameters are independent, and how the others group with them: p_B = p_1 + beta p_2.

    ``independent`` (r,) and ``dependent`` (p - r,) are indices of columns, the first independent ones in order;
    ``beta`` (r, p - r); ``shares`` (p,) the share of each column's length outside those before it, whose gap between
    ``rank_gap`` = (smallest accepted, largest rejected) decides. ``nonnegative`` (p,) are those that no arm has below zero; None where nobody
    says so.
    """

    columns: tuple[Column, ...]
    independent: NDArray[np.intp]
    dependent: NDArray[np.intp]
    beta: Array
    shares: Array
    rank_gap: tuple[float, float]
    nonnegative: NDArray[np.bool_] | None = None

    @property
    def r(self) -> int:
        """Number of base parameters."""
        return len(self.independent)

    @property
    def grouping(self) -> Array:
        """K (r, p) with p_B = K theta, and Y theta = Y[:, independent] K theta."""
        K = np.zeros((self.r, len(self.columns)))
        K[np.arange(self.r), self.independent] = 1.0
        K[:, self.dependent] = self.beta
        return K

    def values(self, theta: Array) -> Array:
        """Base parameters (r,) of parameters (p,)."""
        return theta[self.independent] + self.beta @ theta[self.dependent]

    def nearest(self, nominal: Array, values: Array) -> Array:
        """The parameters (p,) nearest to ``nominal`` (p,) whose base parameters are ``values`` (r,).

        What no motion can show keeps its nominal value. Of a sum, what ``nominal`` says nothing of, as a rotor's inertia that the robot's
        description does not state, takes all that is left beside what it states, as the links, unless it would be less than nothing.
        """
        places = [(column.effect, column.joint) for column in self.columns]
        said = {place for place, value in zip(places, nominal, strict=True) if value != 0}
        stated = np.array([place in said for place in places])
        freedom = np.where(stated, HELD, 1.0)
        found = self._moved(nominal, values, freedom)
        below = ~stated & (found < 0) & (False if self.nonnegative is None else self.nonnegative)
        if below.any():
            found = self._moved(nominal, values, np.where(below, HELD**4, freedom))
            found[below & (np.abs(found) < HELD**2)] = 0.0  # what stays is no sum: the values say so
        return found

    def _moved(self, nominal: Array, values: Array, freedom: Array) -> Array:
        """The parameters (p,) of given base parameters whose distances from ``nominal``, divided by the root of their ``freedom`` (p,), have the least
        sum of squares."""
        K = self.grouping
        KW = K * freedom
        normal = KW @ K.T
        scale = 1 / np.sqrt(np.diag(normal))
        return nominal + KW.T @ (
            scale * np.linalg.solve(scale[:, None] * normal * scale, scale * (values - K @ nominal))
        )

    def expressions(self) -> list[str]:
        """Each base parameter as a sum of standard parameters, for example "Izz_1 + Iyy_2 + 0.18 m_3"."""
        return [self._expression(i) for i in range(self.r)]

    def _expression(self, row: int) -> str:
        text = self.columns[self.independent[row]].name
        for k, factor in enumerate(self.beta[row]):
            if abs(factor) > EXPRESSION_FLOOR:
                size = "" if abs(abs(factor) - 1) < EXPRESSION_FLOOR else f"{abs(factor):.6g} "
                text += f" {'+' if factor > 0 else '-'} {size}{self.columns[self.dependent[k]].name}"
        return text

    def __repr__(self) -> str:
        accepted, rejected = self.rank_gap
        rows = [
            f"{self.r} base parameters of {len(self.columns)} parameters: the sums of parameters that torques depend on"
        ]
        for i, text in enumerate(self.expressions(), 1):
            rows += textwrap.wrap(text, WIDTH, initial_indent=f"  {i:3d}  ", subsequent_indent=" " * 9)
        rows.append(
            f"an independent column keeps at least {accepted:.2g} of its length outside those before it, a dependent one"
            f" {rejected:.1e};\nthe limit between them is {TOLERANCE:.0e}"
        )
        return "\n".join(rows)


def find_base_parameters(robot: Robot, effects: Sequence[Effect], seed: int = 0) -> BaseParameters:
    """Base parameters of a robot with some effects: the ones that motions in general can show, found with a random motion.

    Independent are the first columns in order (Pinocchio's, effect by effect), as thesis eq. 3.46-3.53.
    """
    if not effects:
        raise InputError("no effects given, expected at least one")
    columns = tuple(column for effect in effects for column in effect.columns(robot))
    placed = [effect.moved_to_start() for effect in effects]
    effects = [effect for effect, _ in placed]
    motion = random_motion(robot, seed, max(STATES, int(RATE * (1 + max(seconds for _, seconds in placed)))))
    if any(effect.needs_model for effect in effects):
        motion = Model.nominal(robot, effects).refer(motion)
    Y = np.concatenate([effect.regressor(robot, motion) for effect in effects], axis=2)
    held = np.array([effect.has_prior for effect in effects for _ in effect.columns(robot)])
    R = np.asarray(np.linalg.qr(Y.reshape(-1, len(columns)), mode="r"))
    nonnegative = np.concatenate([_never_negative(effect, robot) for effect in effects])
    return replace(select_base(R, columns, held), nonnegative=nonnegative)


def _never_negative(effect: Effect, robot: Robot) -> NDArray[np.bool_]:
    """Which parameters (k,) of an effect a cone of theirs alone keeps from being negative."""
    result = np.zeros(len(effect.columns(robot)), dtype=bool)
    for cone in effect.cones(robot):
        alone = (np.count_nonzero(cone.map, axis=1) == 1) & (cone.offset == 0) & (cone.map.sum(axis=1) > 0)
        result |= (cone.map[alone] != 0).any(axis=0)
    return result


def random_motion(robot: Robot, seed: int, count: int = STATES) -> Signals:
    """A random motion (count samples at 20 Hz) inside the robot's position limits, one turn either way at most.

    Five sines a joint of random frequency and phase: generic, so that a parameter it does not show is shown by no motion.
    """
    rng = np.random.default_rng(seed)
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    frequency = rng.uniform(0.5, 4.0, size=(5, robot.n))
    phase = frequency * np.arange(count)[:, None, None] / RATE + rng.uniform(0, 2 * np.pi, size=(5, robot.n))
    size = rng.uniform(0.5, 1.0, size=(5, robot.n))
    size *= np.maximum(upper - lower, 1e-3) / 2 / size.sum(axis=0)
    q = (lower + upper) / 2 + (size * np.sin(phase)).sum(axis=1)
    v = (size * frequency * np.cos(phase)).sum(axis=1)
    a = (-size * frequency**2 * np.sin(phase)).sum(axis=1)
    return Signals(
        np.arange(count) / RATE, q, v, a, temperature=20 + np.sin(phase[:, 0]), rate=RATE, source="random motion"
    )


def select_base(R: Array, columns: Sequence[Column], held: NDArray[np.bool_] | None = None) -> BaseParameters:
    """Base parameters of a regressor (or its R factor) with p columns, by Gram-Schmidt in column order.

    Unlike |R_ii| of a plain QR, a column's share is measured against the accepted columns only, so that the rounding
    noise of a dependent one cannot hide a later independent one. Columns that a prior has ``held`` (p,)
    are parameters of their own, whatever one motion shows of them. Raises InputError for a regressor that is all zero.
    """
    held = np.zeros(len(columns), dtype=bool) if held is None else held
    size = np.linalg.norm(R, axis=0)
    if not size.any():
        raise InputError("the regressor is zero in every column; expected a motion that excites some parameter")
    p = R.shape[1]
    largest = {c.effect: max(size[i] for i, d in enumerate(columns) if d.effect == c.effect) for c in columns}
    basis = np.zeros((len(R), 0))
    shares, independent = np.zeros(p), []
    for i in range(p):
        if held[i] or size[i] <= ZERO * largest[columns[i].effect]:
            continue
        rest = R[:, i] / size[i]
        for _ in range(2):  # the second pass removes the rounding errors of the first
            rest = rest - basis @ (basis.T @ rest)
        shares[i] = np.linalg.norm(rest)
        if shares[i] > TOLERANCE:
            basis = np.column_stack([basis, rest / shares[i]])
            independent.append(i)
    shown = np.array(independent, dtype=np.intp)
    chosen = np.sort(np.concatenate([shown, np.flatnonzero(held)]))
    others = np.setdiff1d(np.arange(p), chosen)
    scale, beta = size[shown], np.zeros((len(chosen), len(others)))
    beta[np.isin(chosen, shown)] = np.linalg.lstsq(R[:, shown] / scale, R[:, others], rcond=None)[0] / scale[:, None]
    gap = float(shares[shown].min(initial=1.0)), float(shares[others].max(initial=0.0))
    return BaseParameters(tuple(columns), chosen, others, beta, shares, gap)
