"""The rigid-body regressor: joint torques as a linear function of every link's ten inertial parameters.

Written once as a CasADi expression, so that trajectory design can differentiate it, and evaluated for recordings by
``Vectorised``. Only structural non-zeros are computed: a joint's torque depends only on the links it carries. To compute
torques of known link parameters, ``inverse_dynamics`` is faster.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.vectorised import Vectorised
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
REMEMBERED = 1 << 21  # values at most: a chunk of samples, which is gone before the next one comes


def torque_regressor(robot: Robot, q: Array, v: Array, a: Array) -> Array:
    """Regressor Y (N, n, 10 n) with tau = Y @ theta of the rigid-body dynamics.

    ``q`` [rad|m], ``v`` [rad/s|m/s], ``a`` [rad/s^2|m/s^2] are (N, n); theta is ``Robot.nominal``'s order. Source:
    thesis eq. 3.41; the recursion is Featherstone, "Rigid Body Dynamics Algorithms" (2008), table 5.1, per parameter.
    """
    pattern = torque_pattern(robot)
    Y = np.zeros((len(q), robot.n, 10 * robot.n))
    Y[:, pattern[:, 0], pattern[:, 1]] = torque_entries(robot, q, v, a).T
    return Y


def torque_pattern(robot: Robot) -> NDArray[np.intp]:
    """(E, 2): joint row and parameter column of each structural non-zero, in the order of ``torque_entries``."""
    return _compiled(robot_key(robot)).pattern


def torque_entries(robot: Robot, q: Array, v: Array, a: Array) -> Array:
    """Structural non-zeros (E, N) of the regressor; arguments as in ``torque_regressor``."""
    return _compiled(robot_key(robot)).entries.run(np.concatenate([q.T, v.T, a.T]))


def torque_entries_of(robot: Robot, signals: Signals) -> Array:
    """``torque_entries`` along signals, computed once for all effects that ask for a short piece of them; read-only."""
    key, known = robot_key(robot), _remembered.get(signals)
    if known is not None and known[0] == key:
        return known[1]
    values = torque_entries(robot, signals.q, signals.v, signals.a)
    values.setflags(write=False)
    if values.size <= REMEMBERED:
        _remembered[signals] = key, values
    return values


def torque_expression(robot: Robot) -> Any:
    """The CasADi function (q, v, a) -> Y (n, 10 n), sparse, of one state: the source of exact gradients."""
    return _compiled(robot_key(robot)).function


def robot_key(robot: Robot) -> tuple:
    """Joints and gravity of a robot as hashable numbers: all that its dynamics depend on except the link parameters."""
    joints = tuple((j.kind, j.parent, *map(tuple, (j.axis, j.rotation.ravel(), j.translation))) for j in robot.joints)
    return joints, tuple(robot.gravity)


_remembered: WeakKeyDictionary[Signals, tuple[tuple, Array]] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class _Compiled:
    """The regressor of one state as a CasADi function, the pattern of its non-zeros, and their vectorised evaluation."""

    function: Any
    pattern: NDArray[np.intp]
    entries: Vectorised


@lru_cache(maxsize=32)
def _compiled(key: tuple) -> _Compiled:
    import casadi as ca

    joints, gravity = key
    q, v, a = (ca.SX.sym(name, len(joints)) for name in "qva")
    Y = _symbolic(joints, gravity, q, v, a)
    pattern = np.column_stack(Y.sparsity().get_triplet()).astype(np.intp)
    pattern.setflags(write=False)
    return _Compiled(
        ca.Function("Y", [q, v, a], [Y], ["q", "v", "a"], ["Y"]),
        pattern,
        Vectorised(ca.Function("entries", [ca.vertcat(q, v, a)], [ca.SX(ca.vertcat(*Y.nonzeros()))])),
    )


def _symbolic(joints: tuple, gravity: tuple, q: Any, v: Any, a: Any) -> Any:
    """Y (n, 10 n) as an SX expression."""
    import casadi as ca

    n = len(joints)
    Y = ca.SX(n, 10 * n)
    rays: list[
        dict[int, tuple[Any, Any]]
    ] = []  # for each ancestor joint: its unit motion (linear, angular) in this frame
    for i, body in enumerate(moving_bodies(joints, gravity, q, v, a)):
        above = rays[body.parent] if body.parent >= 0 else {}
        R, arm = body.R, body.arm
        ray = {j: (R.T @ (lin + ca.cross(ang, arm)), R.T @ ang) for j, (lin, ang) in above.items()}
        ray[i] = body.ray
        rays.append(ray)
        for j, (lin, ang) in ray.items():
            Y[j, 10 * i : 10 * i + 10] = _power_coefficients(ca, lin, ang, body.w, body.alpha, body.acc).T
    return ca.sparsify(Y)


@dataclass(frozen=True, eq=False)
class Body:
    """A moving link as SX expressions in the link's frame, except ``arm``.

    ``R`` rotates from the link's frame to the parent's; ``arm`` is the link's origin in the parent's frame; ``ray`` is the
    joint's unit motion (linear, angular); ``w``, ``alpha`` are angular velocity and acceleration; ``acc`` is the
    acceleration of the origin minus gravity; ``field`` (3, 3) times a point is the point's acceleration relative to the
    origin.
    """

    parent: int
    R: Any
    arm: Any
    ray: tuple[Any, Any]
    w: Any
    alpha: Any
    acc: Any
    field: Any


def moving_bodies(joints: tuple, gravity: Any, q: Any, v: Any, a: Any) -> list[Body]:
    """Every link of ``robot_key``'s joints in motion, parents first, under ``gravity`` (3,), numbers or expressions."""
    import casadi as ca

    bodies: list[Body] = []
    zero = ca.SX(3, 1)
    still = Body(-1, None, None, (zero, zero), zero, zero, ca.sparsify(-ca.SX(gravity)), ca.SX(3, 3))
    for i, (kind, parent, axis, rotation, translation) in enumerate(joints):
        s, E0, p = _constant(ca, axis, 3, 1), _constant(ca, rotation, 3, 3), _constant(ca, translation, 3, 1)
        carrier = bodies[parent] if parent >= 0 else still
        turning = kind == "revolute"
        R = (E0 @ _rotation(ca, s, q[i])) if turning else E0
        arm = p if turning else p + E0 @ s * q[i]
        w, alpha, acc = R.T @ carrier.w, R.T @ carrier.alpha, R.T @ (carrier.acc + carrier.field @ arm)
        if turning:
            alpha = alpha + s * a[i] + ca.cross(w, s * v[i])
            w = w + s * v[i]
        else:
            acc = acc + s * a[i] + 2 * ca.cross(w, s * v[i])
        field = ca.skew(alpha) + w @ w.T - ca.sumsqr(w) * ca.SX.eye(3)
        bodies.append(Body(parent, R, arm, (zero, s) if turning else (s, zero), w, alpha, acc, field))
    return bodies


def _power_coefficients(ca: Any, lin: Any, ang: Any, w: Any, alpha: Any, acc: Any) -> Any:
    """Power of one body's wrench along a unit motion (lin, ang), as coefficients (10,) of its parameters.

    Force m acc + alpha x mc + w x (w x mc) and moment mc x acc + I alpha + w x I w about the body frame's origin.
    """
    u = ca.cross(ang, w)  # ang . (w x I w) = (ang x w) . I w
    moment = ca.cross(lin, alpha) + ca.cross(ca.cross(lin, w), w) + ca.cross(acc, ang)
    inertia = [ang[k] * alpha[k] + u[k] * w[k] for k in range(3)]
    product = [ang[i] * alpha[k] + ang[k] * alpha[i] + u[i] * w[k] + u[k] * w[i] for i, k in ((0, 1), (0, 2), (1, 2))]
    return ca.vertcat(ca.dot(lin, acc), moment, inertia[0], product[0], inertia[1], product[1], product[2], inertia[2])


def _rotation(ca: Any, axis: Any, angle: Any) -> Any:
    """Rodrigues' formula, with the structural zeros of an axis along x, y or z kept."""
    K = ca.sparsify(ca.skew(axis))
    c, s = ca.cos(angle), ca.sin(angle)
    outer = ca.sparsify(axis @ axis.T)
    return ca.sparsify(c * (ca.SX.eye(3) - outer) + outer + s * K)


def _constant(ca: Any, values: Any, rows: int, columns: int) -> Any:
    """A constant matrix whose rounding noise (below 1e-15) is a structural zero."""
    matrix = np.asarray(values, dtype=float).reshape(rows, columns)
    return ca.sparsify(ca.SX(ca.DM(np.where(np.abs(matrix) < 1e-15, 0.0, matrix))))
