"""The effects by their public names, as ``identify``, model files and diagnoses use them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import replace
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from physident.effects.classification import Scope
from physident.effects.contact import Contact
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
from physident.effects.inertia import LinkInertia, Payload, RigidBody, RotorInertia
from physident.effects.learned.curves import (
    LearnedLoad,
    LearnedPosition,
    LearnedPositionFriction,
    LearnedTemperature,
    LearnedTime,
    LearnedTorque,
)
from physident.effects.learned.velocity_curve import LearnedVelocity
from physident.effects.measurement import (
    TimeDelay,
    TorqueConstant,
    TorqueCrosstalk,
    TorqueDelay,
    TorqueOffset,
)
from physident.effects.mounting import GravityMagnitude, GravityTilt, JointZeroOffset
from physident.effects.scales.friction_level import FrictionLevel
from physident.effects.scales.torque_scale import TorqueScale
from physident.effects.thermal import WarmUp
from physident.effects.transmission import CoupledFriction, LoadDependentFriction, TorqueRipple
from physident.effects.user.registration import GROUP, add_effect, add_entry_points, effects_in_file
from physident.errors import InputError, did_you_mean, warn
from physident.robots.robot import Robot

ORIGIN = ("effect", "from", "sha256")  # what ``Effect.as_dict`` has beside the settings

# the classes take different settings, for which there is no common type
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
        FrictionLevel,
        CoupledFriction,
        TorqueConstant,
        TorqueScale,
        TorqueCrosstalk,
        TorqueOffset,
        TorqueDelay,
        TimeDelay,
        TorqueRipple,
        JointSpring,
        JointElasticity,
        Payload,
        LinkInertia,
        GravityTilt,
        GravityMagnitude,
        JointZeroOffset,
        Contact,
        LearnedPosition,
        LearnedPositionFriction,
        LearnedVelocity,
        LearnedLoad,
        LearnedTorque,
        LearnedTemperature,
        LearnedTime,
    )
}
DEFAULT_EFFECTS = ("rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction", "torque_offset")


def load_effects(path: str | Path) -> tuple[type[Effect], ...]:
    """Add the effects that a Python file defines to the catalogue, for this process; returns their classes.

    Loaded again, a file replaces what it defined before. Raises InputError, naming the file and the line, for a file that fails,
    that defines no effect, or an effect that is not complete or has the name of another.
    """
    effects, sha256 = effects_in_file(path), hashlib.sha256(Path(path).read_bytes()).hexdigest()
    for effect in effects:
        add_effect(CATALOGUE, effect, str(path), sha256)
    return tuple(effects)


def make_effects(effects: str | Iterable[str | Effect]) -> tuple[Effect, ...]:
    """Effects from names or effect objects, or from one text of names separated by commas; raises InputError for an unknown
    or repeated effect, or for none."""
    if isinstance(effects, str):
        effects = [name.strip() for name in effects.split(",") if name.strip()]
    result = tuple(effect if isinstance(effect, Effect) else effect_class(effect)() for effect in effects)
    if not result:
        raise InputError(f"no effects given, expected at least one of {', '.join(CATALOGUE)}")
    seen: set[tuple[str, object, object, object]] = set()
    for effect in result:
        # each pair of neighbours is a place by itself, though two pairs may share a joint
        places = (effect.joints,) if effect.scope is Scope.NEIGHBOURS else effect.joints or (None,)
        for place in places:
            # contacts at other times or in other recordings are different effects
            key = (effect.name, place, getattr(effect, "intervals", None), getattr(effect, "recording", None))
            if key in seen:
                raise InputError(f"effect {effect.name!r} is given twice for the same joint; expected once")
            seen.add(key)
    return result


def described_effects(robot: Robot) -> tuple[Effect, ...]:
    """The effects that a robot's description gives a size beside its links: a simulator's damping, for example."""
    beside = [kind for name, kind in CATALOGUE.items() if name != "rigid_body"]
    return tuple(effect for kind in beside for effect in kind.described(robot))


def effect_class(name: str) -> Any:
    """The class of an effect by its name; raises InputError for a name that the catalogue does not have."""
    if name not in CATALOGUE:
        raise InputError(
            f"effect {name!r} is unknown, expected some of {', '.join(CATALOGUE)}{did_you_mean(name, CATALOGUE)}"
        )
    return CATALOGUE[name]


def saved_effect_class(data: dict[str, Any]) -> Any:
    """The class of an effect that ``Effect.as_dict`` described; raises InputError for one that the catalogue does not have, saying
    where the model had it from."""
    name, origin = data["effect"], data.get("from")
    if name not in CATALOGUE and isinstance(origin, str):
        remedy = (
            "install that package"
            if origin.startswith("package ")
            else f"give its file again (--effects-from {origin}, in Python physident.load_effects)"
        )
        raise InputError(f"effect {name!r} is not in the catalogue, the model has it from {origin}; {remedy}")
    return effect_class(name)


def warn_of_other_code(saved: Iterable[dict[str, Any]]) -> None:
    """Warn of effects that ``Effect.as_dict`` described and whose file is no longer the one that the model was identified with."""
    known = {data["effect"]: data.get("sha256") for data in saved if data.get("sha256")}
    for name, sha256 in known.items():
        effect = CATALOGUE.get(name)
        if effect is not None and effect.origin_sha256 not in ("", sha256):
            warn(
                f"{effect.origin} is not the file of {name} that the model was identified with; if its law has changed, identify it again"
            )


def effects_from(names: Iterable[str]) -> list[str]:
    """The option of a command that brings those of some effects that come from files of the user; empty where none does."""
    origins = [CATALOGUE[name].origin for name in names if name in CATALOGUE]
    files = list(dict.fromkeys(one for one in origins if one and not one.startswith("package ")))
    return ["--effects-from", *files] if files else []


def effect_label(name: str) -> str:
    """The name of an effect as it stands in a sentence: "torque offset" for ``torque_offset``."""
    label = CATALOGUE[name].label if name in CATALOGUE else ""
    return label or name.replace("_", " ")


def effect_scope(name: str) -> Scope:
    """Where an effect can act, by its name; each joint for a name that the catalogue does not have."""
    return CATALOGUE[name].scope if name in CATALOGUE else Scope.JOINT


def effect_from_dict(data: dict[str, Any]) -> Effect:
    """The effect that ``Effect.as_dict`` described; raises InputError where it describes none."""
    settings = {key: _as_tuples(value) for key, value in data.items() if key not in ORIGIN}
    try:
        return saved_effect_class(data)(**settings)
    except (KeyError, TypeError) as error:
        raise InputError(
            f"effect {data!r} is not understood ({error}); was the model written by a newer version?"
        ) from None


def _as_tuples(value: Any) -> Any:
    return tuple(_as_tuples(v) for v in value) if isinstance(value, list) else value


add_entry_points(CATALOGUE, entry_points(group=GROUP))


def on_joints(effect: Effect, robot: Robot, joints: Sequence[int]) -> Effect:
    """An effect of the joints on some of them (from 1), with the shape parameters and settings that it has there."""
    active = effect.active(robot)
    index = [active.index(joint - 1) for joint in joints]
    fields = (*(shape.field for shape in effect.shape_parameters), *effect.settings_by_joint)
    given = {field: value for field in fields if isinstance(value := getattr(effect, field), tuple)}
    chosen = {field: tuple(v[i] for i in index) if len(v) > 1 else v for field, v in given.items()}
    return replace(effect, joints=tuple(joints), **chosen)
