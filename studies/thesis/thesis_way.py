"""Identification as the thesis does it: two halves, rigid bodies alone, ordinary least squares (eq. 3.61-3.64)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.rigid_body_regressor import torque_regressor
from physident.effects.catalogue import make_effects
from physident.identifiability.base_parameters import BaseParameters, find_base_parameters
from studies.thesis.halves import HALVES, half
from studies.thesis.reference import Run

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class HalfModel:
    """Base parameters (r,) of one half; ``torque`` predicts that half's joints."""

    name: str
    base: BaseParameters
    values: Array

    def torque(self, q: Array, v: Array, a: Array) -> Array:
        """Torque (N, 3) [N m] of the half's joints; q, v, a (N, 3)."""
        Y = torque_regressor(half(self.name), q, v, a)[:, :, self.base.independent]
        return Y @ self.values


def identify_half(name: str, run: Run, joints: slice = slice(None)) -> HalfModel:
    """Ordinary least squares of one half from the run's joints, unfiltered, with exact derivatives (eq. 3.64)."""
    robot = half(name)
    base = find_base_parameters(robot, make_effects(["rigid_body"]))
    Y = torque_regressor(robot, *(x[:, joints] for x in (run.q, run.v, run.a)))[:, :, base.independent]
    values = np.asarray(np.linalg.lstsq(Y.reshape(-1, base.r), run.torque[:, joints].ravel(), rcond=None)[0], float)
    return HalfModel(name, base, values)


def predict_halves(models: list[HalfModel], run: Run) -> Array:
    """Torque (N, 6) [N m] of both halves side by side: eq. 4.3, the coupling between them left out."""
    return np.column_stack([m.torque(*(x[:, HALVES[m.name]] for x in (run.q, run.v, run.a))) for m in models])


def identify_whole_by_halves(run: Run) -> list[HalfModel]:
    """Both halves from the torques of the whole arm."""
    return [identify_half(name, run, joints) for name, joints in HALVES.items()]
