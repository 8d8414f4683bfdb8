"""The hidden effects by their public names: how each changes the machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.plant_mujoco.machine import WEIGHT, Coupling, Machine, Push, Ripple, ordinary
from tests.truth import ArmTruth, HiddenEffect

Array = NDArray[np.float64]


@dataclass(frozen=True)
class _Cause:
    """One effect: ``joints`` from 0, ``size``, and all its settings."""

    joints: tuple[int, ...]
    size: float
    shape: dict[str, Any]

    def row(self, n: int) -> Array:
        """The size (n,) in the places of the joints."""
        row = np.zeros(n)
        row[list(self.joints)] = self.size
        return row


def machine(arm: ArmTruth, warmer: float = 0.0) -> Machine:
    """The arm with everything that was hidden in it."""
    made = ordinary(arm, warmer)
    for effect in arm.effects:
        made = apply(made, effect)
    return replace(made, disturbances=(*arm.background, *arm.disturbances))


def apply(made: Machine, effect: HiddenEffect) -> Machine:
    """The machine with one effect more; ValueError for joints or settings that the effect does not have."""
    act, known = ACTS[effect.effect]
    if strange := set(effect.shape) - set(known):
        raise ValueError(f"{effect.effect}: has no setting {sorted(strange)}, expected {sorted(known)}")
    if any(not 1 <= joint <= made.n for joint in effect.joints):
        raise ValueError(f"{effect.effect}: joints {effect.joints}, expected 1 to {made.n}")
    return act(made, _Cause(tuple(j - 1 for j in effect.joints), float(effect.size), known | effect.shape))


def _grow(field: str) -> Callable[[Machine, _Cause], Machine]:
    return lambda m, c: replace(m, **{field: getattr(m, field) + c.row(m.n)})


def _rub(*fields: str) -> Callable[[Machine, _Cause], Machine]:
    def act(m: Machine, c: _Cause) -> Machine:
        grown = {field: getattr(m.friction, field) + c.row(m.n) for field in fields}
        return replace(m, friction=replace(m.friction, **grown))

    return act


def _dip(m: Machine, c: _Cause) -> Machine:
    more = (*m.friction.dips, (c.row(m.n), float(c.shape["stribeck_speed"])))
    return replace(m, friction=replace(m.friction, dips=more))


def _power(m: Machine, c: _Cause) -> Machine:
    more = (*m.friction.powers, (c.row(m.n), float(c.shape["exponent"])))
    return replace(m, friction=replace(m.friction, powers=more))


def _hysteresis(m: Machine, c: _Cause) -> Machine:
    slip = np.where(c.row(m.n) != 0, float(c.shape["slip"]), m.friction.slip)
    stiffness = m.friction.hysteresis + c.row(m.n)
    return replace(m, friction=replace(m.friction, hysteresis=stiffness, slip=slip))


def _warm_up(m: Machine, c: _Cause) -> Machine:
    time, rise = float(c.shape["time"]), float(c.shape["rise"])
    if rise:
        return replace(m, per_kelvin=(*m.per_kelvin, c.row(m.n)), rise=(rise, time))
    return replace(m, fading=(*m.fading, (c.row(m.n), time)))


def _coupled(m: Machine, c: _Cause) -> Machine:
    if c.size < 0 or len(c.joints) != 2:
        raise ValueError("coupled_friction: needs two joints and a size of at least zero")
    return replace(m, couplings=(*m.couplings, Coupling(*c.joints, c.size, float(c.shape["viscous"]))))


def _ripple(m: Machine, c: _Cause) -> Machine:
    more = tuple(Ripple(j, c.size, float(c.shape["order"]), float(c.shape["phase"])) for j in c.joints)
    return replace(m, ripples=(*m.ripples, *more))


def ball(mass: float, centre: Array, radius: float) -> Array:
    """Parameters (10,) of a homogeneous ball about the frame in which its centre (3,) [m] is given."""
    x, y, z = centre
    own = 0.4 * radius**2
    second = [own + y * y + z * z, -x * y, own + x * x + z * z, -x * z, -y * z, own + x * x + y * y]
    return mass * np.array([1.0, x, y, z, *second])


def _body(m: Machine, c: _Cause) -> Machine:
    links = m.links.copy()
    for i in c.joints or (m.n - 1,):
        centre = links[i, 1:4] / links[i, 0] if c.shape["com"] is None else np.array(c.shape["com"], dtype=float)
        links[i] += ball(c.size, centre, float(c.shape["radius"]))
    return replace(m, links=links)


def _drop(m: Machine, c: _Cause) -> Machine:
    body = ball(c.size, np.array(c.shape["com"], dtype=float), float(c.shape["radius"]))
    return replace(m, drops=(*m.drops, (float(c.shape["time"]), body)))


def _tilt(m: Machine, c: _Cause) -> Machine:
    way = float(c.shape["direction"])
    side = np.sin(c.size) * np.array([np.cos(way), np.sin(way), 0.0])
    return replace(m, gravity=WEIGHT * (side - np.array([0.0, 0.0, np.cos(c.size)])))


def _push(m: Machine, c: _Cause) -> Machine:
    start, end = float(c.shape["start"]), float(c.shape["end"])
    if end <= start:
        raise ValueError(f"contact: ends at {end} s, expected later than its start at {start} s")
    forces = tuple((c.size * x, c.size * y, c.size * z) for x, y, z in c.shape["forces"] or [c.shape["direction"]])
    return replace(m, pushes=(*m.pushes, Push(start, end, forces)))


def _loose(field: str) -> Callable[[Machine, _Cause], Machine]:
    """What parts a rotor from its link; a rotor without inertia would move without bound."""

    def act(m: Machine, c: _Cause) -> Machine:
        if c.size < 0 or (m.rotor[list(c.joints)] <= 0).any():
            raise ValueError(f"{field}: needs a size of at least zero and a rotor with inertia")
        return replace(m, **{field: getattr(m, field) + c.row(m.n)})

    return act


PLACE = (0.03, -0.02, 0.14)  # m, in the frame of the last joint
# name: how it acts, and its settings with their defaults
ACTS: dict[str, tuple[Callable[[Machine, _Cause], Machine], dict[str, Any]]] = {
    "rotor_inertia": (_grow("rotor"), {}),
    "viscous_friction": (_rub("viscous"), {}),
    "coulomb_friction": (_rub("coulomb", "breakaway"), {}),
    "friction_asymmetry": (_rub("asymmetry"), {}),
    "stribeck_friction": (_dip, {"stribeck_speed": 0.05}),
    "nonlinear_viscous_friction": (_power, {"exponent": 0.5}),
    "load_dependent_friction": (_rub("load"), {}),
    "presliding_hysteresis": (_hysteresis, {"slip": 0.01}),
    "warm_up": (_warm_up, {"time": 10.0, "rise": 0.0}),
    "coupled_friction": (_coupled, {"viscous": 0.0}),
    "torque_constant": (_grow("constant"), {}),
    "torque_offset": (_grow("offset"), {}),
    "torque_delay": (_grow("delay"), {}),
    "time_delay": (lambda m, c: replace(m, delay=m.delay + c.size), {}),
    "torque_ripple": (_ripple, {"order": 12.0, "phase": 0.5}),
    "joint_spring": (_grow("spring"), {}),
    "joint_elasticity": (_loose("compliance"), {}),
    "payload": (_body, {"com": PLACE, "radius": 0.05}),
    "link_inertia": (_body, {"com": None, "radius": 0.05}),
    "gravity_tilt": (_tilt, {"direction": 0.7}),
    "joint_zero_offset": (_grow("zero"), {}),
    "contact": (_push, {"start": 5.0, "end": 7.0, "direction": (0.0, 0.0, 1.0), "forces": None}),
    "dropped_load": (_drop, {"com": PLACE, "radius": 0.05, "time": 10.0}),
    "backlash": (_loose("play"), {}),
    "swinging_load": (lambda m, c: replace(m, pendulum=(c.size, float(c.shape["length"]))), {"length": 0.25}),
    "flexible_base": (lambda m, c: replace(m, base=m.base + c.size), {}),
}
