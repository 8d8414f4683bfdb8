"""What a model's effects make of the arm's inertia: every effect of mass added up, link by link."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.effect import AddedInertia, Effect

Array = NDArray[np.float64]


def effect_parameters(model: Model) -> list[tuple[Effect, Array]]:
    """Each effect with its own parameters (k,)."""
    sizes = [len(effect.columns(model.robot)) for effect in model.effects]
    return list(zip(model.effects, np.split(model.theta, np.cumsum(sizes)[:-1]), strict=True))


def added_inertia(model: Model) -> AddedInertia:
    """Link parameters (10 n,) [kg, kg m, kg m^2], rotor inertias (n,) [kg m^2] and change of gravity (3,) [m/s^2], summed
    over the effects."""
    n = model.robot.n
    links, armature, gravity = np.zeros(10 * n), np.zeros(n), np.zeros(3)
    for effect, theta in effect_parameters(model):
        if (added := effect.inertia(model.robot, theta)) is not None:
            links, armature, gravity = links + added.links, armature + added.armature, gravity + added.gravity
    x, y, z = gravity.tolist()
    return AddedInertia(links, armature, (x, y, z))
