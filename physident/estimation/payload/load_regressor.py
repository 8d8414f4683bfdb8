"""What a load fixed to the last link adds to a regressor: ten more parameters, in that link's frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import JointRows, Regressor
from physident.effects.effect import Column
from physident.errors import InputError
from physident.identifiability.base_parameters import BaseParameters
from physident.large_arrays import blocks, empty
from physident.robots.inertia import PARAMETER_NAMES, PARAMETER_UNITS

Array = NDArray[np.float64]
LOAD_RADIUS = 0.05  # m: radius of gyration of the solid load around which a fit is scaled
FARTHEST = 0.5  # m: distance of that load's centre of mass from the last link's frame


def load_regressor(regressor: Regressor, torque: Array, rows: NDArray[np.bool_] | None = None) -> Regressor:
    """The ten columns of a load on the last link, with ``torque`` (M, n) [N m|N] to be explained by it.

    ``rows`` (M,) says which instants carry the load, None for all. Raises InputError for a model without rigid bodies.
    """
    n = len(regressor.joints)
    first = [i for i, c in enumerate(regressor.columns) if c.effect == "rigid_body" and c.joint == n]
    if len(first) != 10:
        raise InputError("the model has no rigid_body effect, expected one: a load acts through the last link")
    joints = []
    for one in regressor.joints:
        last_link = np.isin(one.columns, first)
        plain = empty((len(one.plain), int(last_link.sum())))
        for some in blocks(len(plain)):
            plain[some] = one.plain[some][:, last_link]
        own = JointRows(one.columns[last_link] - first[0], plain, one.weight)
        joints.append(own if rows is None else own.weighted(rows.astype(float)))
    return replace(regressor, columns=load_columns(n + 1), joints=tuple(joints), torque=torque)


def load_columns(number: int) -> tuple[Column, ...]:
    """The columns of a load's parameters, named as those of link ``number``."""
    names = zip(PARAMETER_NAMES, PARAMETER_UNITS, strict=True)
    return tuple(Column(f"{name}_{number}", unit, number, "rigid_body") for name, unit in names)


def all_independent(columns: tuple[Column, ...]) -> BaseParameters:
    """Base parameters of columns that are all independent: the parameters themselves."""
    p = len(columns)
    return BaseParameters(columns, np.arange(p), np.empty(0, dtype=np.intp), np.zeros((p, 0)), np.ones(p), (1.0, 0.0))


def solid_load(mass: float, moment: Array) -> Array:
    """Ten parameters (10,) of a ball of about this mass [kg] and first moment (3,) [kg m]: a scale for a fit, no prior."""
    m = max(float(mass), 0.1)
    c = np.asarray(moment, dtype=float) / m
    c = c * min(1.0, FARTHEST / max(float(np.linalg.norm(c)), 1e-9))
    tensor = m * (2 * LOAD_RADIUS**2 + c @ c) * np.eye(3) - m * np.outer(c, c)
    return np.array([m, *(m * c), *tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]])
