"""The gears: friction that grows with their load, friction that couples two joints, and torque ripple."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.dry_sign import SHARPEST, SMOOTH_SIGN_SOURCE, sign_of_velocity
from physident.effects.classification import Family, JointTerm, Scope, ShapeParameter, Variable, nonnegative
from physident.effects.effect import Array, Column, Cone, Effect, array_source
from physident.errors import InputError
from physident.large_arrays import limits
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

# m: what repeats on a slide is its screw, its pulley or its motor; leads of ball screws by ISO 3408-2, and what belts and poles have
PITCHES = (
    *(0.4, 0.32, 0.25, 0.2, 0.16, 0.15, 0.125, 0.12, 0.1, 0.09, 0.08, 0.075, 0.064, 0.06, 0.05, 0.048, 0.04, 0.036),
    *(0.032, 0.03, 0.025, 0.024, 0.02, 0.016, 0.015, 0.012, 0.01, 0.008, 0.006, 0.005, 0.004, 0.003, 0.0025, 0.002),
)
# Periods of a ripple for each turn of a motor: the wave generator of a strain-wave gear makes two, an offset of a current sensor as many as
# there are pairs of poles, unequal gains twice as many; robot motors have few pairs. More periods pass a cutoff at a creep only.
PERIODS = range(1, 13)
REPEATS = 2  # periods of a ripple that the recordings must show: less is a bend, which springs and cables have too


@dataclass(frozen=True)
class LoadDependentFriction(Effect):
    """tau_j = mu_j sgn(v_j) abs(tau_load_j), tau_load the torque of the links' inertia and gravity, which the gear carries; mu has no unit. Cone: mu >= 0.

    Source: Hamon, Gautier, Garrec, "Dynamic identification of robots with a dry friction model depending on load and
    velocity" (2010), eq. 6.
    """

    name: ClassVar[str] = "load_dependent_friction"
    unit: ClassVar[str] = "1"
    passive: ClassVar[bool] = True
    variable: ClassVar[Variable | None] = "load"
    family: ClassVar[Family] = Family.FRICTION
    label: ClassVar[str] = "load-dependent friction"
    dry: ClassVar[bool] = True
    needs_model: ClassVar[bool] = True
    formulas: ClassVar[tuple[str, ...]] = (f"{SMOOTH_SIGN_SOURCE} * np.abs(load)",)
    signature: ClassVar[str] = "grows with the load and changes sign with the velocity"
    mistaken_for: ClassVar[str] = "torque_constant: does not change sign with the velocity"

    def values(self, robot: Robot, signals: Signals) -> Array:
        return self.torque_at(robot, signals, np.zeros((0, len(signals.time))), signals.from_model("load"))

    def torque_at(self, robot: Robot, signals: Signals, state: Array, load: Array) -> Array:
        active = self.active(robot)
        return sign_of_velocity(signals, active) * np.abs(load.T[active])

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        return (nonnegative(len(self.active(robot))),)


@dataclass(frozen=True)
class CoupledFriction(Effect):
    """tau_j = tau_k = Fc sgn(v_j + v_k) + Fv (v_j + v_k): friction of a motor that turns two joints acts on both.

    ``joints`` (j, k) is the pair, two that turn or two that slide; None for every such pair of neighbours. Fc in N m, Fv in N m s/rad.
    Source: Gautier and Khalil's wrist of the Staubli TX40, "Modeling, Identification and Control of Robots" (2002), sec. 12.
    """

    name: ClassVar[str] = "coupled_friction"
    unit: ClassVar[str] = "N m, N m s/rad"
    family: ClassVar[Family] = Family.FRICTION
    scope: ClassVar[Scope] = Scope.NEIGHBOURS
    dry: ClassVar[bool] = True
    signature: ClassVar[str] = "the residual of one joint follows the motion of another"
    mistaken_for: ClassVar[str] = "friction of one joint alone: move the two joints one at a time"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.joints is not None and len(set(self.joints)) != 2:
            raise InputError(f"coupled_friction: joints are {self.joints}, expected two different ones, (j, k)")

    @classmethod
    def places(cls, robot: Robot) -> list[tuple[int, ...]]:
        return [(j, k) for j, k in super().places(robot) if _add_up(robot, j - 1, k - 1)]

    def pairs(self, robot: Robot) -> list[tuple[int, int]]:
        """The coupled pairs, as indices from 0; raises InputError for a robot without such a pair, and for one joint that turns and one
        that slides."""
        if self.joints is None:
            found = [(j - 1, k - 1) for j, k in self.places(robot)]
            if not found:
                has = "one joint" if robot.n == 1 else "no two joints in a row that both turn or both slide"
                raise InputError(f"coupled_friction: robot {robot.name} has {has}, expected two that share a motor")
            return found
        j, k = self.active(robot)
        if not _add_up(robot, j, k):
            raise InputError(
                f"coupled_friction: of joints {self.joints} of robot {robot.name} one turns and one slides, expected two of one kind:"
                " a sum of rad/s and m/s is no speed of a motor"
            )
        return [(j, k)]

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        kinds = (("coulomb", "N m"), ("viscous", "N m s/rad"))
        return tuple(
            Column(f"{self.name}_{kind}_{j + 1}_{k + 1}", robot.joints[j].unit(unit), j + 1, self.name)
            for j, k in self.pairs(robot)
            for kind, unit in kinds
        )

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        pairs = self.pairs(robot)
        entries = [(row, 2 * p + c) for p, pair in enumerate(pairs) for c in (0, 1) for row in pair]
        return np.array(entries, dtype=np.intp).reshape(-1, 2)

    def values(self, robot: Robot, signals: Signals) -> Array:
        entries = []
        for j, k in self.pairs(robot):
            motor_velocity = signals.v[:, j] + signals.v[:, k]
            sign = sign_of_velocity(_summed(signals, j, k), [0])[0]
            entries += [sign, sign, motor_velocity, motor_velocity]
        return np.array(entries).reshape(-1, len(signals.time))

    def joint_terms(self, robot: Robot, theta: Array) -> tuple[JointTerm, ...]:
        values = zip(self.pairs(robot), theta.reshape(-1, 2).tolist(), strict=True)
        return tuple(JointTerm(pair, damping=Fv, dry=Fc) for pair, (Fc, Fv) in values)

    def numpy_source(self, robot: Robot, theta: Array) -> str:
        """Friction of the summed velocity of each pair, on both joints: a row of P has a one at each joint of a pair."""
        pairs = self.pairs(robot)
        selection = np.zeros((len(pairs), robot.n))
        for row, pair in zip(selection, pairs, strict=True):
            row[list(pair)] = 1.0
        P, Fc, Fv = (array_source(x) for x in (selection, *theta.reshape(-1, 2).T))
        motor_velocity = f"(v @ {P}.T)"
        return f"({Fc} * np.tanh({motor_velocity} / {SHARPEST}) + {Fv} * {motor_velocity}) @ {P}"


def _add_up(robot: Robot, j: int, k: int) -> bool:
    """Whether the speeds of two joints (indices) have one unit, so that their sum may be a motor's."""
    return (robot.joints[j].kind == "prismatic") == (robot.joints[k].kind == "prismatic")


def _summed(signals: Signals, j: int, k: int) -> Signals:
    """The motion of a motor that turns by the sum of two joints' angles."""
    pair = [j, k]
    q, v, a = (x[:, pair].sum(axis=1, keepdims=True) for x in (signals.q, signals.v, signals.a))
    std = None if signals.velocity_std is None else np.hypot.reduce(signals.velocity_std[pair], keepdims=True)
    return replace(signals, q=q, v=v, a=a, velocity_std=std, rests=None, transition=None)


@dataclass(frozen=True)
class TorqueRipple(Effect):
    """tau_j = A_j sin(k q_j) + B_j cos(k q_j), k the ``order`` in periods for each turn of the joint; A, B in N m.

    Causes are the motor - cogging, current sensors with an offset or unequal gains - and the teeth and the wave generator of the
    gear. The joint's side has whole orders (1 to 40). A motor turns G times as fast; where the robot states the gear ratio G, the orders
    G, 2 G ... 12 G are searched, too. A slide has k / 2 pi periods a metre, k in rad/m; common pitches are searched. At velocity
    v the ripple is at k v / 2 pi Hz, and the filter passes it only at low speed, near reversals. A diagnosis searches orders of which
    the recordings show two periods: what does not repeat may be any function of the position.
    """

    order: tuple[float, ...] | None = None

    name: ClassVar[str] = "torque_ripple"
    unit: ClassVar[str] = "N m"
    variable: ClassVar[Variable | None] = "position"
    family: ClassVar[Family] = Family.TRANSMISSION
    shape_parameters: ClassVar = (ShapeParameter("order", "1", tuple(float(k) for k in range(1, 41)), discrete=True),)
    formulas: ClassVar[tuple[str, ...]] = ("np.sin({order} * q)", "np.cos({order} * q)")
    signature: ClassVar[str] = "a line in the order spectrum"
    mistaken_for: ClassVar[str] = "aliasing: its frequency does not follow k v / 2 pi"

    @classmethod
    def search_grid(cls, robot: Robot, joints: tuple[int, ...], shape: ShapeParameter) -> tuple[float, ...]:
        """The grid, with the orders of the motor where the robot states its gear ratio; pitches of a slide."""
        if robot.joints[joints[0] - 1].kind == "prismatic":
            return tuple(2 * np.pi / pitch for pitch in PITCHES)
        if robot.motor_turns is None:
            return shape.grid
        ratio = robot.motor_turns[joints[0] - 1]
        return tuple(dict.fromkeys((*shape.grid, *(periods * ratio for periods in PERIODS))))

    @classmethod
    def search_options(cls, robot: Robot, joints: tuple[int, ...], signals: Sequence[Signals]) -> Sequence[Self]:
        """Orders that the recordings show to repeat; there are none where a joint hardly moves."""
        ends = np.array([limits(one.q[:, joints[0] - 1]) for one in signals])
        turns = float(ends[:, 1].max() - ends[:, 0].min()) / (2 * np.pi)
        every = super().search_options(robot, joints, signals)
        return [one for one in every if one.order is not None and one.order[0] * turns >= REPEATS]

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return tuple(
            Column(f"{self.name}_{kind}_{j + 1}", robot.joints[j].unit(self.unit), j + 1, self.name)
            for j in self.active(robot)
            for kind in ("sin", "cos")
        )

    def in_words(self, robot: Robot, theta: Array) -> str:
        sentences, sizes = [], np.hypot(*theta.reshape(-1, 2).T)
        for j, order, size in zip(self.active(robot), self.shape_values(robot, "order"), sizes, strict=True):
            turns = 1.0 if robot.motor_turns is None else robot.motor_turns[j]
            periods = round(order / turns)
            if turns > 1 and math.isclose(order, periods * turns):
                often = {1: "once", 2: "twice"}.get(periods, f"{periods} times")
                unit = robot.joints[j].unit(self.unit)
                sentences.append(f"Joint {j + 1}: {size:.3g} {unit}, {often} in each turn of its motor.")
        return " ".join(sentences)

    def values(self, robot: Robot, signals: Signals) -> Array:
        angle = self.shape_values(robot, "order")[:, None] * signals.q.T[self.active(robot)]
        return np.stack([np.sin(angle), np.cos(angle)], axis=1).reshape(-1, len(signals.time))

    def cutoff_needed(self, robot: Robot, signals: Signals) -> float:
        fastest = np.abs(signals.v[:, self.active(robot)]).max(axis=0, initial=0.0)
        return float((self.shape_values(robot, "order") * fastest).max(initial=0.0) / (2 * np.pi))
