"""A model with effects more, or with other values of those it has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.effect import Effect
from physident.robots.robot import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Extension:
    """The extended ``model`` and, for each effect that was added or changed, the places of its values in theta."""

    model: Model
    places: tuple[NDArray[np.intp], ...]


def extend(model: Model, effects: Sequence[Effect], changes: Sequence[Array]) -> Extension:
    """The model with concrete effects more, each with its values (k,); one the model has already changes its value.

    The same effect on several joints becomes one effect, its shapes joint by joint.
    """
    robot = model.robot
    new = [e for e in effects if _home(model, e) is None]
    merged = _merged(new)
    every = (*model.effects, *merged)
    whole = Model(robot, every, np.concatenate([model.theta, *(np.zeros(len(e.columns(robot))) for e in merged)]))
    theta, places = np.array(whole.theta), []
    for effect, change in zip(effects, changes, strict=True):
        home = _home(whole, effect)
        assert home is not None
        places.append(home)
        theta[home] += change
    return Extension(replace(whole, theta=theta), tuple(places))


def _home(model: Model, effect: Effect) -> NDArray[np.intp] | None:
    """Where the effect's columns stand in the model's theta, or None where it has no such effect."""
    wanted = _names(effect, model.robot)
    at = 0
    for present in model.effects:
        names = _names(present, model.robot)
        same = present.name == effect.name and getattr(present, "recording", "") == getattr(effect, "recording", "")
        if same and set(wanted) <= set(names):
            return np.array([at + names.index(name) for name in wanted], dtype=np.intp)
        at += len(names)
    return None


@lru_cache(maxsize=4096)  # asked for in every step of every search
def _names(effect: Effect, robot: Robot) -> tuple[str, ...]:
    return tuple(column.name for column in effect.columns(robot))


def _merged(effects: Sequence[Effect]) -> list[Effect]:
    """Effects that differ in their joints and shapes alone, joined; those of a pair or of the whole arm stay apart."""
    groups: dict[tuple, list[Effect]] = {}
    for effect in effects:
        single = effect.joints is not None and len(effect.joints) == 1
        fields = {s.field for s in effect.shape_parameters}
        rest = {k: v for k, v in vars(effect).items() if k != "joints" and k not in fields}
        unset = tuple(f for f in sorted(fields) if getattr(effect, f) is None)
        key = (effect.name, single or effect.joints, unset, *sorted((k, repr(v)) for k, v in rest.items()))
        groups.setdefault(key, []).append(effect)
    result = []
    for group in groups.values():
        group = sorted(group, key=lambda e: e.joints or ())
        first = group[0]
        if first.joints is None or len(first.joints) > 1:
            result += group[:1]
            continue
        fields = {
            s.field: tuple(getattr(e, s.field)[0] for e in group)
            for s in first.shape_parameters
            if getattr(first, s.field) is not None
        }
        result.append(replace(first, joints=tuple(e.joints[0] for e in group if e.joints), **fields))
    return result
