"""Joint torques of a robot with known link parameters, and their derivatives along changes of a joint's motion.

Newton-Euler recursion written as CasADi expressions and evaluated by ``Vectorised``. Source: Featherstone, "Rigid Body
Dynamics Algorithms" (2008), table 5.1, in body coordinates about each link's origin.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.rigid_body_regressor import Body, moving_bodies, robot_key
from physident.dynamics.vectorised import Vectorised
from physident.robots.robot import Robot

Array = NDArray[np.float64]


def inverse_dynamics(robot: Robot, links: Array, q: Array, v: Array, a: Array) -> Array:
    """Joint torques (N, n) [N m|N] of link parameters (10 n,), which need not be physical; q, v, a are (N, n)."""
    return _torque(robot_key(robot)).run(np.concatenate([q.T, v.T, a.T]), links).T


def gravity_torque(robot: Robot, links: Array, q: Array, direction: Array) -> Array:
    """Joint torques (N, n) that hold link parameters (10 n,) still against gravity ``direction`` (3,) [m/s^2]."""
    return _holding(robot_key(robot)[0]).run(np.ascontiguousarray(q.T), np.concatenate([links, direction])).T


def torque_changes(
    robot: Robot, links: Array, state: tuple[Array, Array, Array], joints: tuple[int, ...], motions: Array
) -> Array:
    """Exact derivatives (k, n, N) of ``inverse_dynamics`` at the state (q, v, a), each (N, n), along motions of one joint.

    ``joints``: the k joints (from 0) that move; ``motions`` (k, 1 to 3, N): how the position of each does, and, unless they
    stay, its velocity and its acceleration.
    """
    count, orders, N = motions.shape
    if not joints:
        return np.zeros((0, robot.n, N))
    inputs = np.concatenate([*(x.T for x in state), motions.reshape(count * orders, N)])
    return _changes(robot_key(robot), joints, orders).run(inputs, links).reshape(count, robot.n, N)


def torque_function(robot: Robot) -> Any:
    """The CasADi function (q, v, a, links) -> tau (n,) [N m|N] of one state: the source of generated code."""
    import casadi as ca

    state, links, tau = _symbolic(*robot_key(robot))
    return ca.Function("torque", [*ca.vertsplit(state, robot.n), links], [ca.densify(tau)])


@lru_cache(maxsize=32)
def _torque(key: tuple) -> Vectorised:
    import casadi as ca

    state, links, tau = _symbolic(*key)
    return Vectorised(ca.Function("tau", [state, links], [ca.densify(tau)]))


@lru_cache(maxsize=32)
def _holding(joints: tuple) -> Vectorised:
    import casadi as ca

    n = len(joints)
    q, links, gravity, zero = ca.SX.sym("q", n), ca.SX.sym("links", 10 * n), ca.SX.sym("g", 3), ca.SX(n, 1)
    tau = _newton_euler(moving_bodies(joints, gravity, q, zero, zero), links)
    return Vectorised(ca.Function("holding", [q, ca.vertcat(links, gravity)], [ca.densify(tau)]))


@lru_cache(maxsize=64)
def _changes(key: tuple, joints: tuple[int, ...], orders: int) -> Vectorised:
    """One program for all the joints, which share most operations."""
    import casadi as ca

    state, links, tau = _symbolic(*key)
    n, motions, changes = len(key[0]), ca.SX.sym("motions", len(joints) * orders), []
    for k, joint in enumerate(joints):
        direction = ca.SX(3 * n, 1)
        for order in range(orders):
            direction[order * n + joint] = motions[k * orders + order]
        changes.append(ca.densify(ca.jtimes(tau, state, direction)))
    return Vectorised(ca.Function("changes", [ca.vertcat(state, motions), links], [ca.vertcat(*changes)]))


@lru_cache(maxsize=32)
def _symbolic(joints: tuple, gravity: tuple) -> tuple[Any, Any, Any]:
    """State (3 n,), link parameters (10 n,) and torque (n,) as SX expressions."""
    import casadi as ca

    n = len(joints)
    q, v, a, links = (ca.SX.sym(name, size) for name, size in (("q", n), ("v", n), ("a", n), ("links", 10 * n)))
    return ca.vertcat(q, v, a), links, _newton_euler(moving_bodies(joints, gravity, q, v, a), links)


def _newton_euler(bodies: list[Body], links: Any) -> Any:
    """Torque (n,): every joint carries the wrench of its link about the link's origin, and those of all later links."""
    import casadi as ca

    wrenches = [_wrench(ca, body, links[10 * i : 10 * i + 10]) for i, body in enumerate(bodies)]
    tau = ca.SX(len(bodies), 1)
    for i, body in reversed(list(enumerate(bodies))):
        force, moment = wrenches[i]
        tau[i] = ca.dot(body.ray[0], force) + ca.dot(body.ray[1], moment)
        if body.parent >= 0:
            parent_force, parent_moment = wrenches[body.parent]
            pull = body.R @ force
            wrenches[body.parent] = parent_force + pull, parent_moment + body.R @ moment + ca.cross(body.arm, pull)
    return tau


def _wrench(ca: Any, body: Body, link: Any) -> tuple[Any, Any]:
    """Force m acc + F mc and moment mc x acc + sum of r x F r dm that move a link with acceleration field F.

    The moment's last part is the axial vector of F S with second moments S = tr(I) / 2 - I: fewer products than
    I alpha + w x I w.
    """
    mass, first = link[0], link[1:4]
    xx, xy, yy, xz, yz, zz = (link[k] for k in range(4, 10))
    half = 0.5 * (xx + yy + zz)
    second = ca.vertcat(
        ca.horzcat(half - xx, -xy, -xz), ca.horzcat(-xy, half - yy, -yz), ca.horzcat(-xz, -yz, half - zz)
    )
    spread = body.field @ second
    axial = ca.vertcat(spread[2, 1] - spread[1, 2], spread[0, 2] - spread[2, 0], spread[1, 0] - spread[0, 1])
    return mass * body.acc + body.field @ first, ca.cross(first, body.acc) + axial
