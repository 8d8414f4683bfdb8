"""Effects that are stated by their NumPy formula alone, from which torque, friction and exported code follow."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from typing import Any

import numpy as np

from physident.effects.classification import Column, Family
from physident.effects.effect import Array, Effect
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

KNOWN = ("q", "v", "a", "load", "motor", "t")


@dataclass(frozen=True)
class FormulaEffect(Effect):
    """tau_j = sum_i theta_ij formula_i: each joint has a parameter for each of ``formulas``, NumPy expressions of its q, v and a.

    A formula may also use ``load`` and ``motor`` [N m|N], the torque of the links' inertia and gravity and that of all effects but those on
    the measurement, the time ``t`` [s] of a recording, and shape parameters as {field}. Dry friction, whose sign a noisy velocity
    does not tell, is better a ``VelocityFriction``. Raises InputError for a formula that does not give a torque for each sample.
    """

    def __init_subclass__(cls, **settings: Any) -> None:
        super().__init_subclass__(**settings)
        if isinstance(cls.formulas, str):
            raise InputError(
                f"{cls.__name__}: formulas = {cls.formulas!r} is one text; expected several: formulas = ({cls.formulas!r},)"
            )
        if not all(isinstance(formula, str) for formula in cls.formulas):
            raise InputError(f"{cls.__name__}: formulas = {cls.formulas!r}; expected texts: formulas = ('v**3',)")
        used = {name for formula in cls.formulas for name in _names(formula, cls.__name__)}
        cls.needs_model = cls.needs_model or bool(used & {"load", "motor"})

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        several = len(self.formulas) > 1
        return tuple(
            Column(
                f"{self.name}_{i}_{j + 1}" if several else f"{self.name}_{j + 1}",
                robot.joints[j].unit(self.unit),
                j + 1,
                self.name,
            )
            for j in self.active(robot)
            for i in range(1, len(self.formulas) + 1)
        )

    def values(self, robot: Robot, signals: Signals) -> Array:
        needed = {name for formula in self.formulas for name in _names(formula)}
        model = {name: signals.from_model(name) for name in ("load", "motor") if name in needed}
        return self._evaluated(robot, signals, model)

    def torque_at(self, robot: Robot, signals: Signals, state: Array, load: Array) -> Array:
        return self._evaluated(robot, signals, {"load": load, "motor": load})

    def friction(self, robot: Robot, speeds: Array) -> Array:
        """That of its formulas, where it belongs to friction and each is one of the velocity alone; else zero."""
        if type(self).family is not Family.FRICTION or any(_names(one) & set(KNOWN) != {"v"} for one in self.formulas):
            return super().friction(robot, speeds)
        v = np.tile(speeds[:, None], robot.n)
        return self._evaluated(robot, Signals.of_states(v, v, v), {})

    def _evaluated(self, robot: Robot, signals: Signals, model: dict[str, Array]) -> Array:
        """The formulas' values (k, N) for the joints it acts on, formula by formula of each joint."""
        rows: dict[str, Any] = {"q": signals.q, "v": signals.v, "a": signals.a, **model}
        rows["t"] = (signals.time - signals.origin)[:, None]
        found = []
        for formula in self.formulas:
            try:
                value = eval(self._with_settings(robot, formula), {"np": np, "__builtins__": {}}, rows)
                if np.iscomplexobj(value):
                    raise TypeError("it gives complex numbers")
                found.append(np.broadcast_to(np.asarray(value, dtype=float), signals.v.shape))
            except Exception as error:
                raise InputError(
                    f"{self.name}: the formula {formula!r} cannot be evaluated ({error}); expected NumPy of {', '.join(KNOWN)}"
                ) from None
        joints = self.active(robot)
        return np.stack([value.T[joints] for value in found], axis=1).reshape(-1, len(signals.time))


def _names(formula: str, owner: str = "") -> set[str]:
    """The variables that a formula uses; raises InputError, which names its ``owner``, for a text that is no expression."""
    try:
        tree = ast.parse(formula.replace("{", "").replace("}", ""), mode="eval")
    except SyntaxError as error:
        raise InputError(
            f"{owner or 'effect'}: the formula {formula!r} is no expression of Python ({error.msg}); expected NumPy of"
            f" {', '.join(KNOWN)}"
        ) from None
    return {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
