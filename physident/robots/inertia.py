"""Rigid-body inertia: the ten parameters of a link, its pseudo-inertia matrix, and the conditions of a rigid body."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

PARAMETER_NAMES = ("m", "mcx", "mcy", "mcz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
PARAMETER_UNITS = ("kg", "kg m", "kg m", "kg m") + ("kg m^2",) * 6
TINY = 1e-9  # of the largest of ten parameters: a smaller mass is rounding
Array = NDArray[np.float64]


def pseudo_inertia(phi: Array) -> Array:
    """Pseudo-inertia matrix (4, 4) [kg m^2, kg m, kg] of ten link parameters, linear in them.

    ``phi`` (10,) is Pinocchio's order, inertia about the link frame's origin. Source: Wensing, Kim, Slotine,
    "Linear matrix inequalities for physically consistent inertial parameter identification" (2018), eq. 12.
    """
    m, hx, hy, hz, ixx, ixy, iyy, ixz, iyz, izz = phi
    sxx, syy, szz = (iyy + izz - ixx) / 2, (ixx + izz - iyy) / 2, (ixx + iyy - izz) / 2
    return np.array([[sxx, -ixy, -ixz, hx], [-ixy, syy, -iyz, hy], [-ixz, -iyz, szz, hz], [hx, hy, hz, m]])


def link_parameters(P: Array) -> Array:
    """Ten link parameters (10,) [kg, kg m, kg m^2] of a symmetric pseudo-inertia matrix (4, 4): the inverse map."""
    sxx, syy, szz = P[0, 0], P[1, 1], P[2, 2]
    return np.array([P[3, 3], P[0, 3], P[1, 3], P[2, 3], syy + szz, -P[0, 1], sxx + szz, -P[0, 2], -P[1, 2], sxx + syy])


def violations(phi: Array, tolerance: float = 1e-9) -> list[str]:
    """The condition of a rigid body that ten link parameters (10,) violate, with its likely cause; empty if physical.

    A body is physical when its pseudo-inertia matrix is positive semidefinite, that is: mass not negative, inertia
    about the centre of mass not negative along any axis, and no principal inertia above the sum of the other two.
    """
    if np.linalg.eigvalsh(pseudo_inertia(phi))[0] >= -tolerance * max(1e-3, float(np.abs(phi).max())):
        return []
    if phi[0] <= 0:
        return [f"mass {phi[0]:.4g} kg is not positive"]
    if phi[0] <= TINY * np.abs(phi).max():
        return [f"mass {phi[0]:.4g} kg is too small for its moments"]
    _, inertia = about_centre(phi)
    principal = np.linalg.eigvalsh(inertia)
    values = ", ".join(f"{x:.4g}" for x in principal)
    if principal[0] < 0:
        cause = "given about the wrong point, as the link frame's origin?"
        return [f"inertia about its centre of mass is negative (principal values {values} kg m^2): {cause}"]
    slipped = _fits(np.sort([*principal[:2], principal[2] / 10]))
    cause = ": one principal inertia is about ten times the others: a slipped decimal?" if slipped else ""
    return [f"triangle inequality: the largest of the principal inertias {values} kg m^2 exceeds the sum{cause}"]


def _fits(principal: Array) -> bool:
    """Whether rising principal inertias (3,) can be a body's about its centre of mass."""
    return bool(principal[0] >= 0 and principal[2] <= principal[0] + principal[1])


def inertia_tensor(phi: Array) -> Array:
    """Inertia tensor (3, 3) [kg m^2] about the link frame's origin, of ten link parameters (10,)."""
    ixx, ixy, iyy, ixz, iyz, izz = phi[4:]
    return np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])


def about_centre(phi: Array) -> tuple[Array, Array]:
    """Centre of mass (3,) [m] and inertia tensor (3, 3) [kg m^2] about it, of ten parameters (10,) with a mass."""
    m, c = phi[0], phi[1:4] / phi[0]
    return c, inertia_tensor(phi) - m * (c @ c * np.eye(3) - np.outer(c, c))


def nearest_physical(phi: Array, floor: float = 1e-6) -> Array:
    """Ten link parameters (10,) whose pseudo-inertia is the nearest one with every eigenvalue at least ``floor``.

    Nearest in the Frobenius norm: eigenvalues below the floor are raised to it.
    """
    values, vectors = np.linalg.eigh(pseudo_inertia(phi))
    return link_parameters((vectors * np.maximum(values, floor)) @ vectors.T)
