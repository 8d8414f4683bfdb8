"""A model as a Python function in one file that needs only numpy."""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import units_in_words
from physident.effects.effect import Effect, array_source
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.files import write_text
from physident.robots.robot import Robot

Array = NDArray[np.float64]
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


def export_python(model: Model | Estimate, path: str | Path) -> None:
    """Write a model or an estimate as a Python file with a function ``torque(q, v, a)`` that equals ``Model.torque`` and needs only numpy.

    Raises InputError like ``python_of``, and for a path that cannot be written.
    """
    write_text(path, python_of(model.model if isinstance(model, Estimate) else model))


def python_of(model: Model) -> str:
    """Source text of the model's torque as a function of q [rad|m], v [rad/s|m/s], a [rad/s^2|m/s^2], (n,) or (N, n).

    A model whose effects remember has a ``state`` beside them, one that depends on the time a ``t``; ``torque_along`` is the
    torque along a recording. Raises InputError for an effect that has no such expression: one that changes what the
    encoders show, or that needs other instants.
    """
    robot = model.robot
    inertia = model.added_inertia()
    torques = _effect_torques(model)
    lines = [
        "load = rigid_body(q, v, a)",
        f"motor = load + {array_source(inertia.armature)} * a",
        *torques.plant,
        "tau = motor.copy()",
        *torques.measurement,
    ]
    constants = constants_of(robot, inertia.links, np.array(robot.gravity) + inertia.gravity)
    names = ", ".join(robot.joint_names)
    body = "\n    ".join(lines)
    state = ", state" if torques.advances else ""
    time = ", t=0.0" if torques.timed else ""
    described = f"; ``state`` ({len(torques.advances)}, n) or ({len(torques.advances)}, N, n)" if state else ""
    described += "; ``t`` [s] since the start, a number or (N,)" if time else ""
    along = _along(torques.advances, bool(time), robot.n) if state or time else ""
    return f'''"""Joint torques of {plain(robot.name)}, identified with physident; needs numpy only.

Joints in order: {plain(names)}.
"""

import numpy as np
{constants}
{RIGID_BODY}

def torque(q, v, a{state}{time}):
    """Joint torques [N m|N] at positions q [rad|m], velocities v [rad/s|m/s], accelerations a; each (n,) or (N, n){described}."""
    q, v, a = (np.asarray(x, dtype=float) for x in (q, v, a))
    if not q.shape == v.shape == a.shape or q.shape[-1:] != ({robot.n},):
        raise ValueError(f"q, v, a have shapes {{q.shape}}, {{v.shape}}, {{a.shape}}; expected ({robot.n},) or (N, {robot.n})")
    {"t = np.asarray(t, dtype=float)[..., None]" if time else ""}
    {body}
    return tau
{along}'''


@dataclass(frozen=True)
class _Torques:
    """Lines of code for the effects other than inertia, those of the plant and those of the measurement; ``advances`` the
    expressions of their next states; ``timed`` whether one of them depends on the time."""

    plant: tuple[str, ...]
    measurement: tuple[str, ...]
    advances: tuple[str, ...]
    timed: bool


def _along(advances: tuple[str, ...], timed: bool, n: int) -> str:
    """Functions for a model that remembers or depends on the time: its next state, and the torque along a recording."""
    named = [re.sub(r"\bz\b", f"state[{k}]", expression) for k, expression in enumerate(advances)]
    rows = "".join(f"        {expression},\n" for expression in named)
    step = f'''

def advanced(state, v, dt):
    """The state after a step of dt [s] at the mean velocity v (n,) [rad/s|m/s]; it is zero where a recording begins."""
    v = np.asarray(v, dtype=float)
    return np.array([
{rows}    ])
'''
    states = f"""
    state = np.zeros(({len(advances)}, *v.shape))
    for k in range(1, len(time)):
        state[:, k] = advanced(state[:, k - 1], 0.5 * (v[k - 1] + v[k]), time[k] - time[k - 1])"""
    arguments = (", state" if advances else "") + (", time - time[0]" if timed else "")
    return f'''{step if advances else ""}

def torque_along(time, q, v, a):
    """Joint torques (N, {n}) [N m|N] along a recording without gaps, at times (N,) [s]; other arguments as in ``torque``."""
    time, v = np.asarray(time, dtype=float), np.asarray(v, dtype=float){states if advances else ""}
    return torque(q, v, a{arguments})
'''


def _effect_torques(model: Model) -> _Torques:
    """The lines of all effects other than inertia; raises InputError, naming them, for effects without an expression."""
    plant: list[str] = []
    measurement: list[str] = []
    advances: list[str] = []
    unknown, timed = [], False
    for effect, theta in model.effect_parameters():
        if effect.inertia(model.robot, theta) is not None:
            continue
        source = model.source_of(effect, theta)
        if source is None:
            unknown.append(effect.name)
            continue
        total, target = ("tau", measurement) if effect.acts_on == "measurement" else ("motor", plant)
        if (advance := effect.advance_source(model.robot)) is not None:
            target.append(f"z = np.asarray(state[{len(advances)}], dtype=float)")
            advances.append(advance)
        target.append(f"{total} += {source}  # {effect.name} [{units_in_words(effect.columns(model.robot))}]")
        timed = timed or uses(source, "t")
    if unknown:
        known = [name for name, cls in CATALOGUE.items() if cls.formulas or cls.numpy_source is not Effect.numpy_source]
        raise InputError(
            f"a function torque(q, v, a) cannot express {', '.join(unknown)}; expected effects of inertia and {', '.join(known)}: choose effects with --effects and identify again"
        )
    return _Torques(tuple(plant), tuple(measurement), tuple(advances), timed)


def uses(source: str, name: str) -> bool:
    """Whether an expression depends on a variable."""
    return any(isinstance(node, ast.Name) and node.id == name for node in ast.walk(ast.parse(source)))


def constants_of(robot: Robot, links: Array, gravity: Array) -> str:
    """Source text of the constants that ``RIGID_BODY`` uses."""
    rows = [
        f"    ({j.kind!r}, {j.parent}, {array_source(j.axis)}, {array_source(j.rotation)}, {array_source(j.translation)}),"
        for j in robot.joints
    ]
    table = "\n".join(f"    {row!r}," for row in links.reshape(robot.n, 10).tolist())
    return "\n".join(
        [
            "",
            f"GRAVITY = {array_source(gravity)}  # m/s^2, in the base frame",
            "JOINTS = (  # kind, parent joint (-1: base), axis, rotation and translation [m] of its frame in the parent's",
            *rows,
            ")",
            "LINKS = np.array([  # m [kg], m c [kg m], Ixx Ixy Iyy Ixz Iyz Izz [kg m^2] about the joint frame's origin",
            table,
            "])",
            "INERTIAS = LINKS[:, [4, 5, 7, 5, 6, 8, 7, 8, 9]].reshape(-1, 3, 3)",
            "",
        ]
    )


def plain(text: str) -> str:
    """A name without the characters that would end the docstring around it."""
    return text.replace("\\", "/").replace('"', "'")
