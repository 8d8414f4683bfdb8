"""Which of a model's parameters are of friction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.classification import Family

Array = NDArray[np.float64]


def friction_values(model: Model) -> tuple[Array, Array]:
    """The model's parameters (p,) with those of dry friction alone, and with those of all other friction."""
    dry, other = friction_places(model)
    return model.theta * dry, model.theta * other


def friction_places(model: Model) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which of the model's parameters (p,) are of dry friction, and which of all other friction."""
    dry, other, at = np.zeros(len(model.theta), dtype=bool), np.zeros(len(model.theta), dtype=bool), 0
    for effect, values in model.effect_parameters():
        if effect.family is Family.FRICTION:
            (dry if effect.dry else other)[at : at + len(values)] = True
        at += len(values)
    return dry, other
