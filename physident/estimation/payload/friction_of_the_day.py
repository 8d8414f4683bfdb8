"""The load with the arm's friction and offsets fitted anew: they change from day to day, and tell nothing about a load."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor
from physident.effects.classification import Family
from physident.estimation.uncertainty import BLOCK_PERIODS, FEWEST_BLOCKS, block_labels, correlation_rows, t_quantile

Array = NDArray[np.float64]
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
    columns, torque = load_and_day(model, whole, load, sigma), (load.torque / sigma).reshape(-1)
    left = residual_of(columns, torque)
    labels = blocks_of(load, left)
    value, error, _ = first_coefficient(columns, torque, labels)
    half = t_quantile(int(labels[-1]) + 1) * error
    size = np.sqrt((left.reshape(load.torque.shape) ** 2).mean(axis=0))
    return FrictionOfTheDay(mass=value, mass_interval=(value - half, value + half), sigma=sigma * size)


def lasting(model: Model) -> NDArray[np.bool_]:
    """Which parameters (p,) of a model stay from day to day."""
    families = [effect.family for effect in model.effects for _ in effect.columns(model.robot)]
    return np.array([family not in OF_THE_DAY for family in families])


def load_and_day(model: Model, whole: Regressor, load: Regressor, sigma: Array) -> Array:
    """Columns (M n, 10 + k) in units of ``sigma`` (n,): the load's, and those of friction and offsets, joint by joint."""
    columns = np.concatenate([load.Y, whole.Y[:, :, ~lasting(model)]], axis=2) / sigma[:, None]
    return columns.reshape(-1, columns.shape[2])


def residual_of(columns: Array, torque: Array) -> Array:
    """The residual (M n,) of least squares."""
    columns = columns / _lengths(columns)
    return torque - columns @ np.linalg.lstsq(columns, torque, rcond=RANK)[0]


def blocks_of(load: Regressor, left: Array) -> NDArray[np.intp]:
    """The block (M n,) of each row of a residual (M n,), blocks so long that they are nearly independent."""
    n = load.torque.shape[1]
    length = math.ceil(BLOCK_PERIODS * float(correlation_rows(load, left.reshape(-1, n)).max()))
    return np.repeat(block_labels(load.segment, max(1, min(length, len(load.time) // FEWEST_BLOCKS))), n)


def first_coefficient(columns: Array, torque: Array, labels: NDArray[np.intp]) -> tuple[float, float, Array]:
    """The first column's coefficient, its standard error by leaving out one block at a time, and its derivative (M n,) by the
    torque."""
    size = _lengths(columns)
    columns = columns / size
    normal = columns.T @ columns
    weights = np.linalg.pinv(normal, rcond=RANK, hermitian=True) @ columns.T
    residual = torque - columns @ (weights @ torque)
    deviations = []
    for block in range(labels[-1] + 1):
        rows = columns[labels == block]
        rest = np.linalg.pinv(normal - rows.T @ rows, rcond=RANK, hermitian=True)
        deviations.append(float(rest[0] @ (rows.T @ residual[labels == block])))
    blocks = len(deviations)
    error = math.sqrt((blocks - 1) / blocks * float(np.square(deviations).sum()))
    slope = weights[0] / size[0]
    return float(slope @ torque), error / float(size[0]), slope


def _lengths(columns: Array) -> Array:
    size = np.linalg.norm(columns, axis=0)
    return np.where(size > 0, size, 1.0)
