"""The entries of a model in a file, checked one by one before the model is made of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, get_origin, get_type_hints

from physident.dynamics.model import Model
from physident.effects.catalogue import saved_effect_class, warn_of_other_code
from physident.errors import InputError
from physident.json_records import NotNegative, Range, RecordReader

BEYOND = 1e4  # times the range of values that a shape parameter is searched in: no effect is known there
MotorFriction = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class _Drive:
    gear_ratio: float
    torque_constant: float
    motor_inertia: float
    motor_friction: MotorFriction


@dataclass(frozen=True, kw_only=True)
class _Robot:
    name: str
    gravity: tuple[float, float, float]
    drives: tuple[_Drive, ...] | None
    acceleration_limit: tuple[NotNegative | None, ...] | None
    tool_speed_limit: NotNegative | None
    source: str
    urdf: str


@dataclass(frozen=True, kw_only=True)
class _Parameter:
    name: str
    joint: Annotated[int, Range(0)]
    unit: str
    value: float


@dataclass(frozen=True, kw_only=True)
class _ModelEntries:
    robot: _Robot
    effects: tuple[dict, ...]
    parameters: tuple[_Parameter, ...]


def read_model(data: Any, reader: RecordReader, where: str = "") -> Model:
    """The model that ``Model.as_dict`` described; raises InputError, naming the entry below ``where``, for a wrong type."""
    entries = reader.read(_ModelEntries, data, where)
    for name in ("name", "urdf", "source"):
        if any("\ud800" <= sign <= "\udfff" for sign in getattr(entries.robot, name)):
            raise InputError(f"{where}.robot.{name} has half a character, expected a text; {reader.remedy}".lstrip("."))
    for index, effect in enumerate(entries.effects):
        _check_effect(effect, reader, f"{where}.effects[{index}]".lstrip("."))
    warn_of_other_code(entries.effects)
    return Model.from_dict(data)


def _check_effect(entry: dict[str, Any], reader: RecordReader, where: str) -> None:
    """Raises InputError for a setting of another type than the effect's class states, or a shape beyond all reason."""
    effect = saved_effect_class({**entry, "effect": reader.read(str, entry.get("effect"), f"{where}.effect")})
    hints = get_type_hints(effect, include_extras=True)
    for name, value in entry.items():
        if name in hints and get_origin(hints[name]) is not ClassVar:
            reader.read(hints[name], value, f"{where}.{name}")
    for shape in effect.shape_parameters:
        sizes = [abs(value) for value in shape.grid]
        low, high = min(sizes) / BEYOND, max(sizes) * BEYOND
        for value in entry.get(shape.field) or ():
            if not low <= abs(value) <= high:
                raise InputError(
                    f"{where}.{shape.field} is {value:g}, expected a size from {low:g} to {high:g}; {reader.remedy}"
                )
