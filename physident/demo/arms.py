"""The arms of the demo: a healthy UR5, and the same arm with one hidden change that a seed draws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from physident.dynamics.model import Model
from physident.effects.catalogue import CATALOGUE, DEFAULT_EFFECTS, make_effects
from physident.effects.effect import Effect
from physident.robots.robot import Robot

COULOMB = np.array([7.7, 8.3, 7.8, 1.4, 2.0, 2.1])  # N m
VISCOUS = np.array([9.0, 9.0, 6.0, 2.5, 2.0, 1.5])  # N m s/rad
ROTOR = np.array([1.2, 1.2, 0.9, 0.21, 0.21, 0.21])  # kg m^2
Rng = np.random.Generator
Drawn = tuple[tuple[int, ...], list[float], dict[str, Any]]  # joints from 1, changes of parameters, shape parameters


def _scaled(typical: np.ndarray, low: float, high: float, **settings: tuple[float, ...]) -> Callable[[Rng], Drawn]:
    """A value on one joint, as a share of the typical value there."""

    def draw(rng: Rng) -> Drawn:
        joint = int(rng.integers(1, 7))
        return (joint,), [float(typical[joint - 1] * rng.uniform(low, high))], settings

    return draw


def _hysteresis(rng: Rng) -> Drawn:
    joints, values, _ = _scaled(COULOMB, 0.5, 1.0)(rng)
    distance = round(float(rng.uniform(0.005, 0.03)), 4)
    return joints, [values[0] / distance], {"distance": (distance,)}  # it levels off at value times distance


def _signed(joints: tuple[int, ...], low: float, high: float) -> Callable[[Rng], Drawn]:
    return lambda rng: ((int(rng.choice(joints)),), [float(rng.uniform(low, high) * rng.choice((-1, 1)))], {})


def _loaded(rng: Rng) -> Drawn:
    return (int(rng.integers(2, 4)),), [float(rng.uniform(0.06, 0.15))], {}


def _coupled(rng: Rng) -> Drawn:
    return (5, 6), [float(rng.uniform(0.7, 1.5)), float(rng.uniform(0.4, 1.0))], {}


def _tool(rng: Rng) -> Drawn:
    """A ball of 5 cm radius at the tool."""
    mass, at = float(rng.uniform(0.5, 3.0)), np.array([*rng.uniform(-0.04, 0.04, 2), rng.uniform(0.1, 0.16)])
    inertia = mass * (np.eye(3) * (0.4 * 0.05**2 + at @ at) - np.outer(at, at))
    return (), [mass, *(mass * at), *inertia[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]], {}


def _tilted(rng: Rng) -> Drawn:
    angle, direction = rng.uniform(0.03, 0.08), rng.uniform(0, 2 * np.pi)
    return (), [float(9.81 * angle * np.cos(direction)), float(9.81 * angle * np.sin(direction))], {}


HIDDEN: dict[str, Callable[[Rng], Drawn]] = {
    "coulomb_friction": _scaled(COULOMB, 0.4, 0.8),
    "viscous_friction": _scaled(VISCOUS, 0.4, 0.8),
    "friction_asymmetry": _scaled(VISCOUS, 0.15, 0.3),
    "stribeck_friction": _scaled(COULOMB, 0.8, 1.5, velocity=(0.1,)),
    "presliding_hysteresis": _hysteresis,
    "load_dependent_friction": _loaded,
    "coupled_friction": _coupled,
    "torque_constant": _signed((1, 2, 3, 4, 5, 6), 0.1, 0.2),
    "torque_offset": _scaled(COULOMB, 0.3, 0.6),
    "joint_zero_offset": _signed((2, 3, 4), 0.03, 0.06),
    "payload": _tool,
    "gravity_tilt": _tilted,
}


@dataclass(frozen=True, eq=False)
class Truth:
    """The hidden change: an ``effect`` on ``joints`` (from 1; empty for the whole arm), and the changed ``arm``.

    ``values`` are the changes of its parameters and ``shape`` its shape parameters, each with name and unit.
    """

    effect: str
    joints: tuple[int, ...]
    values: tuple[tuple[str, float, str], ...]
    arm: Model
    shape: tuple[tuple[str, float, str], ...] = ()

    def __repr__(self) -> str:
        place = f" on joint{'s' * (len(self.joints) > 1)} {', '.join(map(str, self.joints))}" if self.joints else ""
        numbers = [(name, f"{value:+.4g}", unit) for name, value, unit in self.values[:4]]
        numbers += [(name, f"{value:.4g}", unit) for name, value, unit in self.shape]
        parts = [f"{name} {value} {'' if unit == '1' else unit}".rstrip() for name, value, unit in numbers]
        return f"{self.effect}{place}: {', '.join(parts)}"


def healthy_arm(robot: Robot) -> Model:
    """The UR5 before the change: nominal links, rotors, viscous and Coulomb friction."""
    effects = make_effects(DEFAULT_EFFECTS)
    known = {"rotor_inertia": ROTOR, "viscous_friction": VISCOUS, "coulomb_friction": COULOMB}
    values = [known[e.name] if e.name in known else e.nominal(robot) for e in effects]
    return Model(robot, effects, np.concatenate(values))


def hide(arm: Model, seed: int) -> Truth:
    """The arm with one additional effect or one changed value, drawn by the seed."""
    rng = np.random.default_rng([seed, 19])
    name = list(HIDDEN)[int(rng.integers(len(HIDDEN)))]
    joints, changes, settings = HIDDEN[name](rng)
    names, shape = {effect.name for effect in arm.effects}, ()
    if name in names:
        changed_columns = [i for i, c in enumerate(arm.columns) if c.effect == name and c.joint in joints]
        theta = arm.theta.copy()
        theta[changed_columns] += changes
        changed = Model(arm.robot, arm.effects, theta)
    else:
        effect: Effect = CATALOGUE[name](joints=joints or None, **settings)
        changed = Model(arm.robot, (*arm.effects, effect), np.concatenate([arm.theta, changes]))
        changed_columns = list(range(len(arm.theta), len(changed.theta)))
        shape = tuple(
            (s.field, float(settings[s.field][0]), s.unit) for s in effect.shape_parameters if s.field in settings
        )
    columns = [changed.columns[i] for i in changed_columns]
    values = tuple((c.name, value, c.unit) for c, value in zip(columns, changes, strict=True))
    return Truth(name, joints, values, changed, shape)
