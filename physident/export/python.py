"""A model as a Python function of its own: one file that needs numpy and nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.effect import Effect
from physident.effects.friction import SMOOTHING
from physident.effects.ripple import TorqueRipple
from physident.effects.transmission import CoupledFriction
from physident.errors import InputError
from physident.export.links import added_inertia, effect_parameters
from physident.files import write_text
from physident.robots.robot import Robot

Array = NDArray[np.float64]
SIGN = f"np.tanh(v / {SMOOTHING})"
FORMULAS: Mapping[str, str] = {  # torque of one unit of each joint's parameter, as the effect's own ``values`` gives it
    "viscous_friction": "v",
    "coulomb_friction": "np.tanh(v / {smoothing})",
    "friction_asymmetry": "np.abs(v)",
    "stribeck_friction": SIGN + " * np.exp(-((v / {velocity}) ** 2))",
    "nonlinear_viscous_friction": "np.sign(v) * np.abs(v) ** {exponent}",
    "load_dependent_friction": SIGN + " * np.abs(load)",
    "joint_spring": "q",
    "torque_constant": "motor",
    "torque_offset": "np.ones_like(v)",
}

RIGID_BODY = '''
def rigid_body(q, v, a):
    """Inertial, Coriolis, centrifugal and gravity torques; arguments as in ``torque``."""
    zero = np.zeros((*q.shape[:-1], 3))
    bodies, wrenches = [], []
    for i, (kind, parent, axis, rotation, translation) in enumerate(JOINTS):
        w0, alpha0, acc0 = bodies[parent][:3] if parent >= 0 else (zero, zero, zero - GRAVITY)
        turns = kind == "revolute"
        s, qi, vi, ai = axis, q[..., i, None], v[..., i, None], a[..., i, None]
        R = rotation @ _turn(axis, q[..., i]) if turns else rotation + np.zeros((*q.shape[:-1], 3, 3))
        arm = translation + zero if turns else translation + qi * (rotation @ s)
        acc = _into(R, acc0 + np.cross(alpha0, arm) + np.cross(w0, np.cross(w0, arm)))
        w, alpha = _into(R, w0), _into(R, alpha0)
        if turns:
            alpha = alpha + s * ai + np.cross(w, s * vi)
            w = w + s * vi
        else:
            acc = acc + s * ai + 2 * np.cross(w, s * vi)
        bodies.append((w, alpha, acc, R, arm))
        m, h, I = LINKS[i, 0], LINKS[i, 1:4], INERTIAS[i]
        force = m * acc + np.cross(alpha, h) + np.cross(w, np.cross(w, h))
        moment = np.cross(h, acc) + alpha @ I + np.cross(w, w @ I)
        wrenches.append((force, moment))
    tau = np.empty(q.shape)
    for i, (kind, parent, axis, _, _) in reversed(list(enumerate(JOINTS))):
        force, moment = wrenches[i]
        tau[..., i] = (moment if kind == "revolute" else force) @ axis
        if parent >= 0:
            R, arm = bodies[i][3:]
            force, moment = _out_of(R, force), _out_of(R, moment)
            wrenches[parent] = (wrenches[parent][0] + force, wrenches[parent][1] + moment + np.cross(arm, force))
    return tau


def _turn(axis, angle):
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle)[..., None, None] * K + (1 - np.cos(angle))[..., None, None] * (K @ K)


def _into(R, x):
    return np.einsum("...ji,...j->...i", R, x)


def _out_of(R, x):
    return np.einsum("...ij,...j->...i", R, x)
'''


def export_python(model: Model, path: str | Path) -> None:
    """Write a Python file with ``torque(q, v, a)`` equal to ``Model.torque``; needs numpy only where it is used.

    Raises InputError as ``python_of`` does, and for a place that cannot be written.
    """
    write_text(path, python_of(model))


def python_of(model: Model) -> str:
    """Source text of the model's torque as a function of q [rad|m], v [rad/s|m/s], a [rad/s^2|m/s^2], (n,) or (N, n).

    Raises InputError, naming it, for an effect that has no formula here: one with a memory or a clock, or that moves what the encoders show.
    """
    robot = model.robot
    inertia = added_inertia(model)
    others = [(effect, theta) for effect, theta in effect_parameters(model) if effect.inertia(robot, theta) is None]
    _refuse_unknown([effect for effect, _ in others])
    lines = [f"load = rigid_body(q, v, a) + np.array({inertia.armature.tolist()!r}) * a", "motor = load.copy()"]
    plant = [pair for pair in others if pair[0].acts_on != "measurement"]
    lines += [f"motor += {_term(effect, robot, theta)}" for effect, theta in plant]
    lines.append("tau = motor.copy()")
    lines += [f"tau += {_term(effect, robot, theta)}" for effect, theta in others if effect.acts_on == "measurement"]
    constants = _constants(robot, inertia.links, np.array(robot.gravity) + inertia.gravity)
    names = ", ".join(robot.joint_names)
    body = "\n    ".join(lines)
    return f'''"""Joint torques of {_plain(robot.name)}, identified with physident; needs numpy only.

Joints in order: {_plain(names)}.
"""

import numpy as np
{constants}
{RIGID_BODY}

def torque(q, v, a):
    """Joint torques [N m|N] at positions q [rad|m], velocities v [rad/s|m/s], accelerations a; each (n,) or (N, n)."""
    q, v, a = (np.asarray(x, dtype=float) for x in (q, v, a))
    if not q.shape == v.shape == a.shape or q.shape[-1:] != ({robot.n},):
        raise ValueError(f"q, v, a have shapes {{q.shape}}, {{v.shape}}, {{a.shape}}; expected ({robot.n},) or (N, {robot.n})")
    {body}
    return tau
'''


def _refuse_unknown(effects: list[Effect]) -> None:
    known = (*FORMULAS, "torque_ripple", "coupled_friction")
    unknown = [effect.name for effect in effects if effect.name not in known]
    if unknown:
        raise InputError(
            f"a function torque(q, v, a) cannot hold {', '.join(unknown)}; expected effects of mass and {', '.join(known)}: identify a model of these with --effects"
        )


def _term(effect: Effect, robot: Robot, theta: Array) -> str:
    """One effect as an expression: a parameter for each joint times its formula, zero where it does not act."""
    if isinstance(effect, TorqueRipple):
        return _ripple(effect, robot, theta)
    if isinstance(effect, CoupledFriction):
        return _coupled(effect, robot, theta)
    active = effect.active(robot)
    shapes = {shape.field: np.ones(robot.n) for shape in effect.shapes}
    for name, values in shapes.items():
        values[active] = effect.shape(robot, name)
    settings = {key: value for key, value in effect.as_dict().items() if isinstance(value, float)}
    settings |= {name: f"np.array({values.tolist()!r})" for name, values in shapes.items()}
    gains = np.zeros(robot.n)
    gains[active] = theta
    formula = FORMULAS[effect.name].format(**settings)
    return f"np.array({gains.tolist()!r}) * {formula}  # {effect.name} [{effect.unit}]"


def _ripple(effect: TorqueRipple, robot: Robot, theta: Array) -> str:
    """Sine and cosine of each joint's angle times its order."""
    active = effect.active(robot)
    order, sine, cosine = np.zeros((3, robot.n))
    order[active] = effect.shape(robot, "order")
    sine[active], cosine[active] = theta.reshape(-1, 2).T
    k, A, B = (f"np.array({x.tolist()!r})" for x in (order, sine, cosine))
    return f"{A} * np.sin({k} * q) + {B} * np.cos({k} * q)  # {effect.name} [{effect.unit}]"


def _coupled(effect: CoupledFriction, robot: Robot, theta: Array) -> str:
    """Friction of the sum of two joints' velocities, on both: a row of ones at each pair."""
    pairs = effect.pairs(robot)
    together = np.zeros((len(pairs), robot.n))
    for row, pair in zip(together, pairs, strict=True):
        row[list(pair)] = 1.0
    P, Fc, Fv = (f"np.array({x.tolist()!r})" for x in (together, *theta.reshape(-1, 2).T))
    w = f"(v @ {P}.T)"
    return f"({Fc} * np.tanh({w} / {SMOOTHING}) + {Fv} * {w}) @ {P}  # {effect.name} [{effect.unit}]"


def _constants(robot: Robot, links: Array, gravity: Array) -> str:
    rows = [
        f"    ({j.kind!r}, {j.parent}, np.array({j.axis.tolist()!r}), np.array({j.rotation.tolist()!r}), np.array({j.translation.tolist()!r})),"
        for j in robot.joints
    ]
    table = "\n".join(f"    {row!r}," for row in links.reshape(robot.n, 10).tolist())
    return "\n".join(
        [
            "",
            f"GRAVITY = np.array({gravity.tolist()!r})  # m/s^2, in the base frame",
            "JOINTS = (  # kind, joint before it (-1: base), axis, rotation and translation [m] of its frame in that one's",
            *rows,
            ")",
            "LINKS = np.array([  # m [kg], m c [kg m], Ixx Ixy Iyy Ixz Iyz Izz [kg m^2] about the joint frame's origin",
            table,
            "])",
            "INERTIAS = LINKS[:, [4, 5, 7, 5, 6, 8, 7, 8, 9]].reshape(-1, 3, 3)",
            "",
        ]
    )


def _plain(text: str) -> str:
    """A name that cannot end the docstring it stands in."""
    return text.replace("\\", "/").replace('"', "'")
