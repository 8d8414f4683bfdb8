"""Hiding an effect: a change of the arm's truth, by the effect's public name.

Joints count from 1. ``magnitude`` adds to what the arm has, one value or one for each joint, in the unit of the effect's
parameter; so effects can be hidden one after another, and friction can also fall.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from tests.plant.arm import GRAVITY, Arm, Contact, Dropped, Hidden
from tests.plant.drives import Ripple
from tests.plant.friction import Coupling

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Dose:
    """``joints``: indices from 0 of ``count``; ``magnitude``: one for each; ``shape``: the effect's own settings."""

    count: int
    joints: list[int]
    magnitude: list[float]
    shape: dict[str, Any]

    @property
    def row(self) -> Array:
        """The magnitudes (n,) in the places of their joints."""
        row = np.zeros(self.count)
        row[self.joints] = self.magnitude
        return row


def hide(arm: Arm, effect: str, joints: int | Sequence[int], magnitude: float | Sequence[float], **shape: Any) -> Arm:
    """The arm with an effect more; ``arm.hidden`` remembers it.

    Raises KeyError for an unknown effect, ValueError for joints, magnitudes or settings that do not fit it.
    """
    names = (joints,) if isinstance(joints, int) else tuple(joints)
    if any(not 1 <= joint <= arm.joints for joint in names):
        raise ValueError(f"{effect}: joints {names}, expected 1 to {arm.joints}")
    count = max(1, len(names))
    values = (float(magnitude),) * count if isinstance(magnitude, int | float) else tuple(map(float, magnitude))
    if len(values) != count:
        raise ValueError(f"{effect}: {len(values)} magnitudes for {count} joints")
    act, known = EFFECTS[effect]
    if unknown := set(shape) - set(known):
        raise ValueError(f"{effect}: has no setting {sorted(unknown)}, expected {sorted(known)}")
    changed = act(arm, _Dose(arm.joints, [joint - 1 for joint in names], list(values), known | shape))
    memory = Hidden(effect, names, values, tuple((known | shape).items()))
    return replace(changed, hidden=(*arm.hidden, memory))


def _friction(kind: str, *settings: str) -> Callable[[Arm, _Dose], Arm]:
    """A friction of each joint alone: its field grows by the magnitudes, its settings are taken as given."""

    def act(arm: Arm, dose: _Dose) -> Arm:
        grown = {kind: getattr(arm.friction, kind) + dose.row}
        return replace(arm, friction=replace(arm.friction, **grown, **{name: dose.shape[name] for name in settings}))

    return act


def _drive(kind: str) -> Callable[[Arm, _Dose], Arm]:
    def act(arm: Arm, dose: _Dose) -> Arm:
        return replace(arm, drives=replace(arm.drives, **{kind: getattr(arm.drives, kind) + dose.row}))

    return act


def _warm_up(arm: Arm, dose: _Dose) -> Arm:
    """Coulomb and viscous friction times 1 + c exp(-t/time), or, with a ``rise`` of temperature [K] that the time
    constant ``time`` [s] leads to, times 1 + c (temperature - first temperature)."""
    rise, time = dose.shape["rise"], dose.shape["time"]
    friction = arm.friction
    if not rise:
        return replace(arm, friction=replace(friction, warmth=friction.warmth + dose.row, warm_time=time))
    friction = replace(friction, warmth_per_degree=friction.warmth_per_degree + dose.row)
    return replace(arm, friction=friction, temperature_rise=np.full(arm.joints, float(rise)), temperature_time=time)


def _coupled(arm: Arm, dose: _Dose) -> Arm:
    """``magnitude`` sgn(v_j + v_k) + ``viscous`` (v_j + v_k) in both rows."""
    first, second = dose.joints
    pair = Coupling(first, second, dose.magnitude[0], dose.shape["viscous"])
    return replace(arm, friction=replace(arm.friction, couplings=(*arm.friction.couplings, pair)))


def _time_delay(arm: Arm, dose: _Dose) -> Arm:
    return replace(arm, drives=replace(arm.drives, time_delay=arm.drives.time_delay + dose.magnitude[0]))


def _ripple(arm: Arm, dose: _Dose) -> Arm:
    order, phase = dose.shape["order"], dose.shape["phase"]
    more = [Ripple(joint, A, order, phase) for joint, A in zip(dose.joints, dose.magnitude, strict=True)]
    return replace(arm, drives=replace(arm.drives, ripples=(*arm.drives.ripples, *more)))


def _ball(mass: float, com: Any, radius: float) -> Array:
    """Parameters (10,) of a homogeneous ball about the origin of its frame."""
    place = pin.SE3(np.eye(3), np.array(com, dtype=float))
    return mass * pin.Inertia.FromSphere(1.0, radius).se3Action(place).toDynamicParameters()


def _body(arm: Arm, dose: _Dose) -> Arm:
    """A homogeneous ball of ``magnitude`` [kg] and ``radius`` [m] at ``com`` [m] in the frame of its link's joint."""
    links = arm.links.copy()
    for i, mass in zip(dose.joints or [arm.joints - 1], dose.magnitude, strict=True):
        com = links[i, 1:4] / links[i, 0] if dose.shape["com"] is None else dose.shape["com"]
        links[i] += _ball(mass, com, dose.shape["radius"])
    return replace(arm, links=links)


def _dropped(arm: Arm, dose: _Dose) -> Arm:
    """A ball like a payload's that the last link loses at ``time`` [s]."""
    body = _ball(dose.magnitude[0], dose.shape["com"], dose.shape["radius"])
    return replace(arm, dropped=(*arm.dropped, Dropped(dose.shape["time"], body)))


def _tilt(arm: Arm, dose: _Dose) -> Arm:
    """Upright gravity turned by ``magnitude`` [rad] towards ``direction`` [rad] from the base's x axis."""
    angle, way = dose.magnitude[0], dose.shape["direction"]
    down = np.array([np.sin(angle) * np.cos(way), np.sin(angle) * np.sin(way), -np.cos(angle)])
    return replace(arm, gravity=GRAVITY * down)


def _contact(arm: Arm, dose: _Dose) -> Arm:
    """Force ``magnitude`` [N] times ``direction`` (3,) from ``start`` to ``end`` [s], or times ``forces`` (P, 3), each for an
    equal part of that time."""
    forces = dose.shape["forces"] or [dose.shape["direction"]]
    size = dose.magnitude[0]
    scaled = tuple((size * x, size * y, size * z) for x, y, z in forces)
    return replace(arm, contacts=(*arm.contacts, Contact(dose.shape["start"], dose.shape["end"], scaled)))


def _row(kind: str) -> Callable[[Arm, _Dose], Arm]:
    def act(arm: Arm, dose: _Dose) -> Arm:
        return replace(arm, **{kind: getattr(arm, kind) + dose.row})

    return act


# name: how it acts, and its settings with their defaults
EFFECTS: dict[str, tuple[Callable[[Arm, _Dose], Arm], dict[str, Any]]] = {
    "rotor_inertia": (_drive("rotor_inertia"), {}),
    "viscous_friction": (_friction("viscous"), {}),
    "coulomb_friction": (_friction("coulomb"), {}),
    "friction_asymmetry": (_friction("asymmetry"), {}),
    "stribeck_friction": (_friction("stribeck", "stribeck_speed"), {"stribeck_speed": 0.05}),
    "nonlinear_viscous_friction": (_friction("power", "exponent"), {"exponent": 0.5}),
    "load_dependent_friction": (_friction("load_dependent"), {}),
    "presliding_hysteresis": (_friction("stiffness", "slip"), {"slip": 0.01}),
    "warm_up": (_warm_up, {"time": 10.0, "rise": 0.0}),
    "coupled_friction": (_coupled, {"viscous": 0.0}),
    "torque_constant": (_drive("torque_constant"), {}),
    "torque_offset": (_drive("torque_offset"), {}),
    "torque_delay": (_drive("channel_delay"), {}),
    "time_delay": (_time_delay, {}),
    "torque_ripple": (_ripple, {"order": 12.0, "phase": 0.5}),
    "joint_spring": (_row("spring"), {}),
    "joint_elasticity": (_drive("compliance"), {}),
    "payload": (_body, {"com": (0.03, -0.02, 0.14), "radius": 0.05}),
    "link_inertia": (_body, {"com": None, "radius": 0.05}),
    "gravity_tilt": (_tilt, {"direction": 0.7}),
    "joint_zero_offset": (_row("zero_offset"), {}),
    "contact": (_contact, {"start": 5.0, "end": 7.0, "direction": (0.0, 0.0, 1.0), "forces": None}),
    "dropped_load": (_dropped, {"com": (0.03, -0.02, 0.14), "radius": 0.05, "time": 10.0}),
}
