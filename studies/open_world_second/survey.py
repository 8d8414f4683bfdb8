"""What an arm's joints usually bear, and how much of that a disturbance makes: the yardstick of all sizes here."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from studies.open_world_second import steps, waves
from studies.open_world_second.bodies import rigid
from tests.truth import ArmTruth, Disturbance

Array = NDArray[np.float64]
RATE = 100.0  # Hz
LASTS = 15.0  # s
PLANS = (waves.fourier, steps.errands, waves.lissajous)
SEED = 77001  # of the motions that measure; no trial draws it


@dataclass(frozen=True, eq=False)
class Stretch:
    """A motion and what it costs: ``time`` (N,) [s]; ``q``, ``v`` and ``torque`` [N m or N] are (N, n)."""

    time: Array
    q: Array
    v: Array
    torque: Array


@dataclass(frozen=True, eq=False)
class Survey:
    """Several motions of one arm."""

    stretches: tuple[Stretch, ...]

    @property
    def load(self) -> Array:
        """Root mean square torque (n,) over all motions [N m or N]."""
        return _rms([part.torque for part in self.stretches])

    def quantile(self, joint: int, share: float) -> float:
        """Position [rad or m] of a joint (from 0) below which it stays for a share of the time."""
        return float(np.quantile(np.concatenate([part.q[:, joint] for part in self.stretches]), share))

    def spread(self, joint: int) -> float:
        """Distance [rad or m] between the positions below which a joint (from 0) stays for 10 % and for 90 %."""
        return self.quantile(joint, 0.9) - self.quantile(joint, 0.1)

    def share(self, *disturbances: Disturbance) -> Array:
        """Root mean square (n,) of what disturbances add to the reported torque, relative to ``load``."""
        return _rms([felt(part, *disturbances) for part in self.stretches]) / self.load


def survey(arm: ArmTruth) -> Survey:
    """Three motions of an arm with the torque of its bodies, rotors and plain friction."""
    return Survey(tuple(_stretch(arm, plan(arm, SEED, LASTS).states(_instants())) for plan in PLANS))


def felt(part: Stretch, *disturbances: Disturbance) -> Array:
    """What disturbances add to the reported torque (N, n) of a motion, to first order where drives deliver less."""
    asked = part.torque.copy()
    for each in disturbances:
        for i, now in enumerate(part.time):
            extra = each.resist(now, part.q[i], part.v[i])
            if extra is not None:
                asked[i] += extra
            asked[i] += part.torque[i] - each.deliver(now, part.v[i], part.torque[i])
    for each in disturbances:
        asked = each.report(part.time, part.q, part.v, asked)
    return asked - part.torque


def _stretch(arm: ArmTruth, states: tuple[Array, Array, Array]) -> Stretch:
    q, v, a = states
    model, data = rigid(arm.urdf, arm.links)
    torque = np.array([pin.rnea(model, data, *row) for row in zip(q, v, a, strict=True)])
    torque += arm.rotor_inertia * a + arm.friction.coulomb * np.sign(v) + arm.friction.viscous * v
    return Stretch(_instants(), q, v, torque)


def _instants() -> Array:
    return np.arange(int(LASTS * RATE) + 1) / RATE


def _rms(parts: list[Array]) -> Array:
    return np.sqrt(np.mean(np.concatenate(parts) ** 2, axis=0))
