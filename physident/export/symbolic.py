"""A model as CasADi expressions: torque, its derivatives and its regressor, the source of generated code."""

from __future__ import annotations

import ast
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.inverse_dynamics import torque_function
from physident.dynamics.model import Model
from physident.dynamics.rigid_body_regressor import torque_expression
from physident.effects.effect import Effect
from physident.errors import InputError
from physident.robots.robot import Robot

Array = NDArray[np.float64]
NAMES = {  # NumPy's name of a function, and CasADi's
    "abs": "fabs", "sign": "sign", "exp": "exp", "log": "log", "sqrt": "sqrt", "sin": "sin", "cos": "cos", "tan": "tan",
    "tanh": "tanh", "sinh": "sinh", "cosh": "cosh", "arcsinh": "asinh", "arctan": "atan", "arctan2": "atan2",
    "minimum": "fmin", "maximum": "fmax",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class SymbolicModel:
    """Expressions of one instant of a model with n joints, p parameters and S states of n numbers.

    The arguments ``q``, ``v``, ``a`` (n,), ``z`` (S n,) row by row, ``t`` [s] and ``dt`` [s]; ``torque`` (n,) [N m|N];
    ``regressor`` (n, p), whose columns that depend on the model's own torque have the values of the model; ``advanced``
    (S n,) the states after a step dt at the velocity v.
    """

    q: Any
    v: Any
    a: Any
    z: Any
    t: Any
    dt: Any
    torque: Any
    regressor: Any
    advanced: Any

    @property
    def states(self) -> int:
        """How many numbers the states have."""
        return int(self.z.numel())


def symbolic_model(model: Model) -> SymbolicModel:
    """The expressions of a model; raises InputError, naming them, for effects that have none of one instant."""
    import casadi as ca

    robot, inertia = model.robot, model.added_inertia()
    n, p = robot.n, len(model.columns)
    q, v, a = (ca.SX.sym(name, n) for name in "qva")
    t, dt = ca.SX.sym("t"), ca.SX.sym("dt")
    remembering = [e for e in model.effects if e.advance_source(robot) is not None]
    z = ca.SX.sym("z", n * len(remembering))
    rows = {"q": q.T, "v": v.T, "a": a.T, "t": t, "dt": dt}
    x, y, up = np.array(robot.gravity) + inertia.gravity
    heavy = replace(robot, gravity=(float(x), float(y), float(up)))
    load = torque_function(heavy)(q, v, a, inertia.links)
    tau = load + inertia.armature * a
    rows |= {"load": load.T, "motor": tau.T}
    regressor, advanced = ca.SX(n, p), []
    parts = list(_placed(model))
    _refuse_unknown(robot, parts)
    Y = torque_expression(robot)(q, v, a)  # gravity that effects add has columns of its own
    for stage in ("motor", "measured"):
        for effect, theta, columns in parts:
            if (effect.acts_on == "measurement") != (stage == "measured"):
                continue
            if effect.advance_source(robot) is not None:
                k = remembering.index(effect)
                rows["z"] = z[k * n : (k + 1) * n].T
                advanced.append((k, _evaluated(effect.advance_source(robot), effect, rows)))
            for unit, column in zip(np.eye(len(theta)), columns, strict=True):
                regressor[:, column] = _column(model, effect, unit, inertia.links, rows, Y)
            if effect.inertia(robot, theta) is None:
                tau = tau + _evaluated(model.source_of(effect, theta), effect, rows).T
        rows["motor"] = tau.T
    ordered = [value for _, value in sorted(advanced, key=lambda item: item[0])]
    after = ca.vertcat(*(value.T for value in ordered)) if ordered else ca.SX(0, 1)
    return SymbolicModel(q, v, a, z, t, dt, ca.densify(tau), ca.densify(regressor), after)


def _placed(model: Model) -> Any:
    """Each effect with its parameters (k,) and the places of its columns."""
    at = 0
    for effect, theta in model.effect_parameters():
        yield effect, theta, range(at, at + len(theta))
        at += len(theta)


def _refuse_unknown(robot: Robot, parts: list[tuple[Effect, Array, range]]) -> None:
    unknown = [
        effect.name
        for effect, theta, _ in parts
        if effect.inertia(robot, theta) is None and effect.numpy_source(robot, theta) is None
    ]
    if unknown:
        raise InputError(
            f"generated code cannot express {', '.join(unknown)}; expected effects of one instant: choose effects with --effects and identify again"
        )


def _column(model: Model, effect: Effect, unit: Array, links: Array, rows: dict[str, Any], Y: Any) -> Any:
    """One column (n,) of the regressor: the torque of a unit of one parameter."""
    robot = model.robot
    added = effect.inertia(robot, unit)
    if added is None:
        return _evaluated(model.source_of(effect, unit), effect, rows).T
    column = Y @ added.links + added.armature * rows["a"].T
    if any(added.gravity):
        pulled = replace(robot, gravity=added.gravity)
        column = column + torque_function(pulled)(rows["q"].T, 0, 0, links)
    return column


def _evaluated(source: str | None, effect: Effect, rows: dict[str, Any]) -> Any:
    """A NumPy expression of an effect, evaluated with CasADi's functions on rows (1, n)."""
    import casadi as ca

    assert source is not None
    known: dict[str, Any] = {name: getattr(ca, ours) for name, ours in NAMES.items()}
    known["array"] = lambda values: ca.DM(values).T if np.ndim(values) == 1 else ca.DM(values)
    known["ones_like"] = lambda x: ca.SX.ones(*x.shape)
    known["zeros_like"] = lambda x: ca.SX.zeros(*x.shape)
    used = {node.attr for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Attribute)} - {"T"}
    if unknown := sorted(used - set(known)):
        raise InputError(
            f"generated code cannot express {effect.name}: its formula uses np.{unknown[0]}, expected some of {', '.join(known)}"
        )
    value = eval(source, {"np": SimpleNamespace(**known), "__builtins__": {}}, rows)
    return value if value.shape == rows["v"].shape else value * ca.SX.ones(1, rows["v"].shape[1])
