"""What pinocchio and closed forms expect of the plant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from tests.plant_mujoco.plant import MujocoPlant
from tests.plant_mujoco.samples import Kind, Sines, sample, sines
from tests.truth import ArmTruth, Disturbance, Run

Array = NDArray[np.float64]
PLANT = MujocoPlant()
MOVING = 2e-3  # rad/s
KINDS: tuple[Kind, ...] = ("dry", "bristle", "smooth")


def model_of(arm: ArmTruth) -> Any:
    """Pinocchio's model of an arm with its true links, without rotors."""
    model = pin.buildModelFromXML(arm.urdf)
    for i, link in enumerate(arm.links, 1):
        model.inertias[i] = pin.Inertia.FromDynamicParameters(link)
    return model


def rnea(model: Any, q: Array, v: Array, a: Array) -> Array:
    """Torque (N, n) [N m] of inertia and gravity along a motion (N, n)."""
    data = model.createData()
    return np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])


def load_of(arm: ArmTruth, run: Run) -> Array:
    """Torque (N, n) [N m] of links and rotors along a run."""
    return rnea(model_of(arm), run.q, run.v, run.a) + arm.rotor_inertia * run.a


def still(n: int, duration: float = 2.0) -> Sines:
    """No motion, for so long [s]."""
    return sines(n, duration, scale=0.0)


def simulated(name: str, kind: Kind, duration: float = 4.0, **changes: Any) -> tuple[ArmTruth, Run]:
    """One of the sample arms, and what happened when it moved."""
    arm = sample(name, kind, **changes)
    return arm, PLANT.simulate(arm, sines(arm.joints, duration))


def sliding(run: Run) -> NDArray[np.bool_]:
    """Where joints move and do not stop or turn back within a step."""
    way = np.sign(run.v)
    stops = np.zeros_like(run.v, dtype=bool) if run.at_rest is None else run.at_rest
    return (np.abs(run.v) > MOVING) & (np.roll(way, 1, axis=0) == way) & (np.roll(way, -1, axis=0) == way) & ~stops


def steady_friction(arm: ArmTruth, v: Array) -> Array:
    """Steady friction (N, n) [N m] at speeds (N, n) [rad/s] away from zero."""
    f = arm.friction
    peak = (f.breakaway - f.coulomb) / np.cosh(v / f.stribeck_speed)
    return np.sign(v) * (f.coulomb + peak) + f.viscous * v


@dataclass(frozen=True)
class Rising(Disturbance):
    """A torque [N m] on the first joint that grows with time."""

    rate: float

    def resist(self, time: float, q: Array, v: Array) -> Array | None:
        return np.concatenate([[self.rate * time], np.zeros(len(q) - 1)])
