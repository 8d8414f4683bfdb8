"""The rigid-body regressor: joint torques as a linear function of every link's ten inertial parameters.

Written once as a CasADi expression, so that trajectory design can differentiate it, and evaluated for recordings by
running its instruction list on NumPy arrays, a cache-sized chunk of samples at a time. Only structural non-zeros are
computed: a joint's torque depends on the links it carries, and on nothing else.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.robot import Robot

Array = NDArray[np.float64]
CHUNK = 1024  # samples: the work arrays of a 6-joint arm then fit a second-level cache


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
    return _compiled(_key(robot)).pattern


def torque_entries(robot: Robot, q: Array, v: Array, a: Array) -> Array:
    """Structural non-zeros (E, N) of the regressor; arguments as in ``torque_regressor``."""
    return _compiled(_key(robot)).run(np.concatenate([q.T, v.T, a.T]))


def inverse_dynamics(robot: Robot, links: Array, q: Array, v: Array, a: Array) -> Array:
    """Joint torques (N, n) [N m|N] of link parameters (10 n,), which need not be physical; q, v, a are (N, n)."""
    program = _compiled(_key(robot))
    return _summed(program, links, program.run(np.concatenate([q.T, v.T, a.T])))


def gravity_torque(robot: Robot, links: Array, q: Array, direction: Array) -> Array:
    """Joint torques (N, n) that hold link parameters (10 n,) still against gravity ``direction`` (3,) [m/s^2]."""
    program = _compiled((_key(robot)[0], tuple(float(g) for g in direction)))
    return _summed(program, links, program.run(np.concatenate([q.T, np.zeros((2 * robot.n, len(q)))])))


def _summed(program: _Program, links: Array, entries: Array) -> Array:
    tau = np.zeros((len(program.sums), entries.shape[1]))
    for row, (own, columns) in enumerate(program.sums):
        tau[row] = links[columns] @ entries[own]
    return tau.T


def torque_expression(robot: Robot) -> Any:
    """The CasADi function (q, v, a) -> Y (n, 10 n), sparse, of one state: the source of exact gradients."""
    return _compiled(_key(robot)).function


def _key(robot: Robot) -> tuple:
    joints = tuple((j.kind, j.parent, *map(tuple, (j.axis, j.rotation.ravel(), j.translation))) for j in robot.joints)
    return joints, tuple(robot.gravity)


@lru_cache(maxsize=32)
def _compiled(key: tuple) -> _Program:
    return _Program(*key)


class _Program:
    """The symbolic regressor and its instruction list, ready to run on arrays of samples."""

    def __init__(self, joints: tuple, gravity: tuple) -> None:
        import casadi as ca

        n = len(joints)
        q, v, a = (ca.SX.sym(name, n) for name in "qva")
        Y = _symbolic(joints, gravity, q, v, a)
        self.function = ca.Function("Y", [q, v, a], [Y], ["q", "v", "a"], ["Y"])
        rows, columns = map(np.array, Y.sparsity().get_triplet())
        self.pattern = np.column_stack([rows, columns]).astype(np.intp)
        self.pattern.setflags(write=False)
        owned = [np.flatnonzero(rows == j) for j in range(n)]
        self.sums = [(own, self.pattern[own, 1]) for own in owned]
        self._instructions(ca, ca.Function("entries", [ca.vertcat(q, v, a)], [ca.SX(ca.vertcat(*Y.nonzeros()))]))

    def _instructions(self, ca: Any, function: Any) -> None:
        binary = {ca.OP_ADD: np.add, ca.OP_SUB: np.subtract, ca.OP_MUL: np.multiply}
        unary = {
            ca.OP_NEG: np.negative,
            ca.OP_SQ: np.square,
            ca.OP_SIN: np.sin,
            ca.OP_COS: np.cos,
            ca.OP_ASSIGN: np.positive,
        }
        self.slots = function.sz_w()
        self.program: list[tuple[Any, tuple[int, ...], int]] = []
        self.constants: list[tuple[int, float]] = []
        self.inputs: list[tuple[int, int]] = []
        self.outputs: list[tuple[int, int]] = []
        for k in range(function.n_instructions()):
            op, source, target = (
                function.instruction_id(k),
                function.instruction_input(k),
                function.instruction_output(k),
            )
            if op == ca.OP_CONST:
                self.program.append((float(function.instruction_constant(k)), (), target[0]))
            elif op == ca.OP_INPUT:
                self.program.append((None, (source[1],), target[0]))
            elif op == ca.OP_OUTPUT:
                self.program.append((np.copyto, (source[0],), target[1]))
            elif op == ca.OP_TWICE:
                self.program.append((np.add, (source[0], source[0]), target[0]))
            elif op in binary:
                self.program.append((binary[op], tuple(source), target[0]))
            else:
                self.program.append((unary[op], tuple(source[:1]), target[0]))

    def run(self, states: Array) -> Array:
        """Structural non-zeros (E, N) for states (3 n, N): q, v, a stacked."""
        N = states.shape[1]
        entries = np.empty((len(self.pattern), N))
        work = np.empty((self.slots, min(CHUNK, N)))
        for start in range(0, N, CHUNK):
            stop = min(start + CHUNK, N)
            w, x, out = work[:, : stop - start], states[:, start:stop], entries[:, start:stop]
            for operation, source, target in self.program:
                if operation is None:
                    w[target] = x[source[0]]
                elif operation is np.copyto:
                    out[target] = w[source[0]]
                elif isinstance(operation, float):
                    w[target] = operation
                elif len(source) == 2:
                    operation(w[source[0]], w[source[1]], w[target])
                else:
                    operation(w[source[0]], w[target])
        return entries


def _symbolic(joints: tuple, gravity: tuple, q: Any, v: Any, a: Any) -> Any:
    """Y (n, 10 n) as an SX expression. Every vector is in the frame of the body it is written down for."""
    import casadi as ca

    n = len(joints)
    Y = ca.SX(n, 10 * n)
    bodies: list[tuple[Any, Any, Any]] = []  # angular velocity, angular acceleration, linear acceleration of the origin
    rays: list[dict[int, tuple[Any, Any]]] = []  # by ancestor joint: its unit motion (linear, angular) in this frame
    for i, (kind, parent, axis, rotation, translation) in enumerate(joints):
        s, E0, p = _constant(ca, axis, 3, 1), _constant(ca, rotation, 3, 3), _constant(ca, translation, 3, 1)
        zero = ca.SX(3, 1)
        w0, alpha0, acc0 = bodies[parent] if parent >= 0 else (zero, zero, _constant(ca, [-g for g in gravity], 3, 1))
        turning = kind == "revolute"
        R = (E0 @ _rotation(ca, s, q[i])) if turning else E0  # from this frame to the parent's
        arm = p if turning else p + E0 @ s * q[i]  # from the parent's origin to this one, in the parent's frame
        w, alpha = R.T @ w0, R.T @ alpha0
        acc = R.T @ (acc0 + ca.cross(alpha0, arm) + ca.cross(w0, ca.cross(w0, arm)))
        if turning:
            alpha = alpha + s * a[i] + ca.cross(w, s * v[i])
            w = w + s * v[i]
        else:
            acc = acc + s * a[i] + 2 * ca.cross(w, s * v[i])
        bodies.append((w, alpha, acc))
        above = rays[parent] if parent >= 0 else {}
        ray = {j: (R.T @ (lin + ca.cross(ang, arm)), R.T @ ang) for j, (lin, ang) in above.items()}
        ray[i] = (zero, s) if turning else (s, zero)
        rays.append(ray)
        for j, (lin, ang) in ray.items():
            Y[j, 10 * i : 10 * i + 10] = _power_coefficients(ca, lin, ang, w, alpha, acc).T
    return ca.sparsify(Y)


def _power_coefficients(ca: Any, lin: Any, ang: Any, w: Any, alpha: Any, acc: Any) -> Any:
    """What the wrench of one body does along a unit motion (lin, ang), as coefficients (10,) of its parameters.

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
