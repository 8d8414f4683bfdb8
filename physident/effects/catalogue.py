"""The effects by their public names: what can be asked for in ``identify``, stored in a model, named in a diagnosis."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from physident.effects.contact import Contact
from physident.effects.drive import RotorInertia, TorqueConstant, TorqueOffset
from physident.effects.effect import Effect
from physident.effects.elastic import JointElasticity, JointSpring
from physident.effects.friction import (
    CoulombFriction,
    FrictionAsymmetry,
    NonlinearViscousFriction,
    StribeckFriction,
    ViscousFriction,
)
from physident.effects.hysteresis import PreslidingHysteresis
from physident.effects.mounting import GravityTilt, JointZeroOffset
from physident.effects.payload import LinkInertia, Payload
from physident.effects.rigid_body import RigidBody
from physident.effects.ripple import TorqueRipple
from physident.effects.thermal import WarmUp
from physident.effects.timing import TimeDelay
from physident.effects.transmission import CoupledFriction, LoadDependentFriction
from physident.errors import InputError

# classes of effects by name; each takes settings of its own, which no common type can say
CATALOGUE: dict[str, Any] = {
    effect.name: effect
    for effect in (
        RigidBody,
        RotorInertia,
        ViscousFriction,
        CoulombFriction,
        FrictionAsymmetry,
        StribeckFriction,
        NonlinearViscousFriction,
        LoadDependentFriction,
        PreslidingHysteresis,
        WarmUp,
        CoupledFriction,
        TorqueConstant,
        TorqueOffset,
        TimeDelay,
        TorqueRipple,
        JointSpring,
        JointElasticity,
        Payload,
        LinkInertia,
        GravityTilt,
        JointZeroOffset,
        Contact,
    )
}
DEFAULT_EFFECTS = ("rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction", "torque_offset")


def make_effects(effects: Iterable[str | Effect]) -> tuple[Effect, ...]:
    """Effects from names or ready-made objects; raises InputError for an unknown or repeated one, or for none."""
    made = tuple(effect if isinstance(effect, Effect) else _by_name(effect)() for effect in effects)
    if not made:
        raise InputError(f"no effects given, expected at least one of {', '.join(CATALOGUE)}")
    seen: set[tuple[str, int | None, object, object]] = set()
    for effect in made:
        for joint in effect.joints or (None,):
            # contacts at other times, or in other recordings, are others
            key = (effect.name, joint, getattr(effect, "intervals", None), getattr(effect, "recording", None))
            if key in seen:
                raise InputError(f"effect {effect.name!r} is given twice for the same joint; expected once")
            seen.add(key)
    return made


def effect_from_dict(data: dict[str, Any]) -> Effect:
    """The effect that ``Effect.as_dict`` described."""
    settings = {key: _tupled(value) for key, value in data.items() if key != "effect"}
    try:
        return _by_name(data["effect"])(**settings)
    except (KeyError, TypeError) as error:
        raise InputError(
            f"effect {data!r} is not understood ({error}); was the model written by a newer version?"
        ) from None


def _tupled(value: Any) -> Any:
    return tuple(_tupled(v) for v in value) if isinstance(value, list) else value


def _by_name(name: str) -> Any:
    if name not in CATALOGUE:
        raise InputError(f"effect {name!r} is unknown, expected some of {', '.join(CATALOGUE)}")
    return CATALOGUE[name]
