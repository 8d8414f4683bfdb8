"""Friction with memory: the rubbing surfaces deflect like a bristle over a short distance before they slide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.effects.classification import Family, ShapeParameter, nonnegative
from physident.effects.effect import Array, Cone, Effect
from physident.effects.friction import CoulombFriction
from physident.large_arrays import BLOCK, blocks
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

SETTLING_TRAVEL = 3.0  # times the presliding distance: exp(-3) = 5 % of the earlier deflection is left
FORGOTTEN = 40.0  # times the presliding distance: exp(-40) of the earlier deflection is less than rounding


@dataclass(frozen=True)
class PreslidingHysteresis(Effect):
    """tau_j = s_j z_j with dz/dt = v - abs(v) z / xs, from z = 0 where a recording or a segment begins; s in N m/rad.

    The deflection z [rad] reaches +-xs, the presliding ``distance`` [rad]; the sliding friction is s xs. After a gap z
    starts at zero again, and the rows of the first 3 xs of travel are left out. Source: Dahl, "A solid friction model"
    (1968), eq. 3 with exponent 1. Cone: s >= 0.
    """

    distance: tuple[float, ...] | None = None

    name: ClassVar[str] = "presliding_hysteresis"
    unit: ClassVar[str] = "N m/rad"
    family: ClassVar[Family] = Family.FRICTION
    dry: ClassVar[bool] = True
    pointwise: ClassVar[bool] = False
    shape_parameters: ClassVar = (
        # the longest is three degrees: a gear whose friction needs more to build up would be no gear
        ShapeParameter(
            "distance", "rad", (0.0002, 0.0005, 0.001, 0.002, 0.004, 0.007, 0.01, 0.015, 0.025, 0.05), bounded="last"
        ),
    )
    formulas: ClassVar[tuple[str, ...]] = ("z",)
    advance: ClassVar[str] = (
        "np.sign(v) * {distance} + (z - np.sign(v) * {distance}) * np.exp(-np.abs(v) * dt / {distance})"
    )
    signature: ClassVar[str] = "friction builds over a fixed distance after each reversal"
    mistaken_for: ClassVar[str] = (
        "stribeck_friction: follows speed, not distance; reversals at three speeds separate them"
    )

    def values(self, robot: Robot, signals: Signals) -> Array:
        return bristle(signals.v.T[self.active(robot)], self.shape_values(robot, "distance"), signals.rate)

    def change_in_words(self, robot: Robot, theta: Array, before: Array) -> str:
        """The sliding friction s xs of each joint, which its stiffness s [N m/rad] alone does not say."""
        each = zip(self.active(robot), theta, before, self.shape_values(robot, "distance"), strict=True)
        sentences = []
        for j, stiffness, old, distance in each:
            unit, now = robot.joints[j].unit("N m"), f"{stiffness * distance:.3g}"
            change = f", changed by {(stiffness - old) * distance:+.3g} {unit}" if old else ""
            sentences.append(f"Once joint {j + 1} slides, this friction is {now} {unit}{change}.")
        return " ".join(sentences)

    def unsettled(self, robot: Robot, signals: Signals) -> NDArray[np.intp] | None:
        if signals.time[0] - signals.origin < 1 / signals.rate:
            return None  # a recording begins at rest; only after a gap is the deflection unknown
        active, travelled = self.active(robot), np.zeros(robot.n)
        distance, result = SETTLING_TRAVEL * self.shape_values(robot, "distance"), np.zeros(robot.n, dtype=np.intp)
        for rows in blocks(len(signals.time)):
            travel = travelled[active] + np.cumsum(np.abs(signals.v[rows][:, active]), axis=0) / signals.rate
            result[active] += (travel < distance).sum(axis=0)
            travelled[active] = travel[-1]
            if (travelled[active] >= distance).all():
                break
        return result

    def around(self, robot: Robot, signals: Signals, samples: slice) -> slice:
        active, travelled = self.active(robot), 0.0
        far = FORGOTTEN * self.shape_values(robot, "distance")
        first = samples.start
        while first > 0 and not np.all(travelled >= far):
            rows = slice(max(0, first - BLOCK), first)
            travelled = travelled + np.abs(signals.v[rows][:, active]).sum(axis=0) / signals.rate
            first = rows.start
        return slice(first, samples.stop)

    def friction(self, robot: Robot, speeds: Array) -> Array:
        return self.shape_values(robot, "distance")[:, None] * np.sign(speeds)

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        """A bristle that deflects holds back."""
        return (nonnegative(len(self.active(robot))),)

    def state_size(self, robot: Robot) -> int:
        return len(self.active(robot))

    def state_rate(self, robot: Robot, signals: Signals, state: Array) -> Array:
        v = signals.v.T[self.active(robot)]
        return v - np.abs(v) * state / self.shape_values(robot, "distance")[:, None]

    def torque_at(self, robot: Robot, signals: Signals, state: Array, load: Array) -> Array:
        return state

    def folded(self, robot: Robot, theta: Array) -> tuple[Effect, Array]:
        """Coulomb friction of the level s xs that it reaches after a few presliding distances."""
        return CoulombFriction(self.joints), theta * self.shape_values(robot, "distance")


def bristle(v: Array, distance: Array, rate: float) -> Array:
    """Deflection z (k, N) [rad] of bristles with presliding ``distance`` (k,) [rad] under velocities (k, N) [rad/s].

    Exact where the velocity is constant between samples: over a step, z decays towards xs sgn v with the travel.
    """
    step = 0.5 * (v[:, 1:] + v[:, :-1]) / rate  # travel between samples
    decay = np.exp(-np.abs(step) / distance[:, None])
    gain = np.sign(step) * distance[:, None] * (1 - decay)
    # z_{k+1} = decay_k z_k + gain_k, solved for all k by doubling: each pass joins spans twice as long as the last
    span = 1
    while span < step.shape[1]:
        gain[:, span:] += decay[:, span:] * gain[:, :-span]
        decay[:, span:] *= decay[:, :-span]
        span *= 2
    return np.concatenate([np.zeros((len(v), 1)), gain], axis=1)
