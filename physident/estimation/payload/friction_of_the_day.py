"""The load with the arm's friction and offsets fitted anew: they change from day to day, and tell nothing about a load."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor
from physident.effects.classification import Family
from physident.estimation.uncertainty import BLOCK_PERIODS, FEWEST_BLOCKS, block_labels, correlation_rows, t_quantile
from physident.large_arrays import blocks, empty, row_slices, triangle

Array = NDArray[np.float64]
INSTANTS = 1 << 13  # of the dense regressor at once
RANK = 1e-9  # of the largest singular value, columns scaled to unit length
OF_THE_DAY = (Family.FRICTION, Family.MEASUREMENT)


@dataclass(frozen=True, eq=False, kw_only=True)
class FrictionOfTheDay:
    """Mass [kg] of a load beside friction that is fitted anew, its 95 % interval ``mass_interval`` (2,), and ``sigma`` (n,)
    [N m|N], the RMS residual that is left then."""

    mass: float
    mass_interval: tuple[float, float]
    sigma: Array


def refit_friction(model: Model, whole: Regressor, load: Regressor, sigma: Array) -> FrictionOfTheDay:
    """The load beside new friction: ``whole`` and ``load`` are the arm's and the load's weighted regressors, ``sigma`` (n,)
    [N m|N] the residual."""
    rows = Rows(load.torque, sigma, lambda some: load_and_day(model, whole, load, sigma, some))
    left = rows.residual(rows.solve())
    labels = blocks_of(load, left)
    fit = first_coefficient(rows, labels)
    half = t_quantile(fit.blocks) * fit.error
    return FrictionOfTheDay(
        mass=fit.value,
        mass_interval=(fit.value - half, fit.value + half),
        sigma=sigma * np.sqrt((left**2).mean(axis=0)),
    )


def lasting(model: Model) -> NDArray[np.bool_]:
    """Which parameters (p,) of a model stay from day to day."""
    families = [effect.family for effect in model.effects for _ in effect.columns(model.robot)]
    return np.array([family not in OF_THE_DAY for family in families])


def load_and_day(model: Model, whole: Regressor, load: Regressor, sigma: Array, some: slice) -> Array:
    """Columns (K n, 10 + k) of some instants in units of ``sigma`` (n,): the load's, and those of friction and offsets, joint by
    joint."""
    day = whole.dense(some)[:, :, ~lasting(model)]
    columns = np.concatenate([load.dense(some), day], axis=2) / sigma[:, None]
    return columns.reshape(-1, columns.shape[2])


@dataclass(frozen=True, eq=False)
class Rows:
    """Least squares of M instants of n joints, a block of instants at a time: ``torque`` (M, n) in units of ``sigma`` (n,), and
    ``columns``, which gives those (K n, c) of some instants."""

    torque: Array
    sigma: Array
    columns: Callable[[slice], Array]

    def response(self, some: slice) -> Array:
        """The torque (K n,) of some instants."""
        return (self.torque[some] / self.sigma).reshape(-1)

    @cached_property
    def factor(self) -> Array:
        """The R factor (c + 1, c + 1) of all columns, with the torque as the last one."""
        every = blocks(len(self.torque), INSTANTS)
        return triangle(np.column_stack([self.columns(some), self.response(some)]) for some in every)

    def solve(self) -> Array:
        """The coefficients (c,)."""
        return solve_factor(self.factor[:, :-1], self.factor[:, -1])

    def residual(self, x: Array) -> Array:
        """The residual (M, n) of coefficients (c,)."""
        left = empty(self.torque.shape)
        for some in blocks(len(left), INSTANTS):
            left[some] = (self.response(some) - self.columns(some) @ x).reshape(-1, left.shape[1])
        return left


def solve_factor(columns: Array, torque: Array) -> Array:
    """Least squares (c,) of columns (m, c), each scaled to unit length."""
    size = _lengths(columns)
    return np.linalg.lstsq(columns / size, torque, rcond=RANK)[0] / size


def blocks_of(load: Regressor, left: Array) -> NDArray[np.intp]:
    """The block (M,) of each instant of a residual (M, n), blocks so long that they are nearly independent."""
    length = math.ceil(BLOCK_PERIODS * float(correlation_rows(load, left).max()))
    return block_labels(load.segment, max(1, min(length, len(load.time) // FEWEST_BLOCKS)))


@dataclass(frozen=True, eq=False)
class FirstCoefficient:
    """The first column's coefficient, its standard error from a number of ``blocks``, and ``slope`` (c,): its derivative by the
    torque is columns @ slope."""

    value: float
    error: float
    blocks: int
    slope: Array


def first_coefficient(rows: Rows, labels: NDArray[np.intp]) -> FirstCoefficient:
    """The first column's coefficient with its standard error by leaving out one block, by ``labels`` (M,), at a time."""
    size = _lengths(rows.factor[:, :-1])
    products = [_products(rows, size, start, stop) for start, stop in _ends(labels)]
    normal, right = np.sum([N for N, _ in products], axis=0), np.sum([z for _, z in products], axis=0)
    inverse = np.linalg.pinv(normal, rcond=RANK, hermitian=True)
    x = inverse @ right
    deviations = []
    for N, z in products:
        rest = np.linalg.pinv(normal - N, rcond=RANK, hermitian=True)
        deviations.append(float(rest[0] @ (z - N @ x)))
    G = len(products)
    error = math.sqrt((G - 1) / G * float(np.square(deviations).sum())) / float(size[0])
    return FirstCoefficient(float(x[0] / size[0]), error, G, inverse[0] / size / size[0])


def _ends(labels: NDArray[np.intp]) -> list[tuple[int, int]]:
    """First instant and end of each block."""
    starts = np.flatnonzero(np.diff(labels, prepend=-1)).tolist()
    return list(itertools.pairwise([*starts, len(labels)]))


def _products(rows: Rows, size: Array, start: int, stop: int) -> tuple[Array, Array]:
    N, z = np.zeros((len(size), len(size))), np.zeros(len(size))
    for some in row_slices([slice(start, stop)]):
        A = rows.columns(some) / size
        N, z = N + A.T @ A, z + A.T @ rows.response(some)
    return N, z


def _lengths(columns: Array) -> Array:
    size = np.linalg.norm(columns, axis=0)
    return np.where(size > 0, size, 1.0)
