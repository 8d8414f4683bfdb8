"""Errors of the torque measurement: a wrong torque constant, torque that leaks between channels, a constant offset, a late channel or clock."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.effects.classification import Cone, Family, Scope, Variable, every_joint_pattern
from physident.effects.effect import Array, Column, Effect, array_source
from physident.effects.kinds_of_values import OneByOne
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

TOLD = 0.3  # of the largest share of another joint's torque: smaller ones are in the model, and not worth a word


@dataclass(frozen=True)
class TorqueConstant(Effect):
    """tau_j = (1 + k_j) tau_m_j: the measured torque of a joint is scaled by a wrong gain; k has no unit.

    tau_m is the model's torque without measurement effects. A common k on all joints is invisible without a known mass.
    Cone: k >= -1, because a channel of the wrong sign is a wrong set-up and no gain.
    """

    name: ClassVar[str] = "torque_constant"
    unit: ClassVar[str] = "1"
    variable: ClassVar[Variable | None] = "torque"
    family: ClassVar[Family] = Family.MEASUREMENT
    acts_on: ClassVar = "measurement"
    needs_model: ClassVar[bool] = True
    formulas: ClassVar[tuple[str, ...]] = ("motor",)
    signature: ClassVar[str] = "the whole torque of one joint is scaled"
    mistaken_for: ClassVar[str] = "a wrong mass: it changes the torque of several joints"

    def values(self, robot: Robot, signals: Signals) -> Array:
        return signals.from_model("motor").T[self.active(robot)]

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        k = len(self.active(robot))
        return (Cone(np.eye(k), np.ones(k)),)

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        assert signals.torque is not None
        scale = np.ones(robot.n)
        scale[self.active(robot)] += theta
        return replace(signals, torque=signals.torque * scale)

    def in_words(self, robot: Robot, theta: Array) -> str:
        return " ".join(_gain_in_words(j + 1, float(k)) for j, k in zip(self.active(robot), theta, strict=True))


def _gain_in_words(joint: int, k: float) -> str:
    """What a channel shows that is scaled by 1 + k, and what that means for a motor whose current is measured."""
    text = f"Joint {joint} shows {100 * abs(k):.3g} % {'more' if k > 0 else 'less'} torque than the model needs there"
    if k <= -1:
        return f"{text}."
    motor = 100 * abs(1 / (1 + k) - 1)
    read, gives = ("high", "less") if k > 0 else ("low", "more")
    return f"{text}: it is read too {read}, or the motor gives {motor:.3g} % {gives} torque for a current."


@dataclass(frozen=True)
class TorqueCrosstalk(OneByOne):
    """tau_j = tau_m_j + sum over i != j of k_ji tau_m_i: the torque channel of a joint shows a share of what other joints carry.

    tau_m is the model's torque without measurement effects. A sensor in a joint feels the bending that the torques about other axes
    make, and its amplifier the wires beside it; torques that were computed from motor currents have none. ``joints`` are those whose channels show it, each a share of every other joint's
    torque. k has no unit between two joints that turn, or two that slide; else it is in N m/N or N/(N m).
    """

    name: ClassVar[str] = "torque_crosstalk"
    unit: ClassVar[str] = "1"
    family: ClassVar[Family] = Family.MEASUREMENT
    acts_on: ClassVar = "measurement"
    needs_model: ClassVar[bool] = True
    needs_torque_sensor: ClassVar[bool] = True
    signature: ClassVar[str] = "a share of another joint's torque, also while this joint rests"
    mistaken_for: ClassVar[str] = "coupled_friction: that acts on both joints and follows their speed"

    @classmethod
    def places(cls, robot: Robot) -> list[tuple[int, ...]]:
        return super().places(robot) if robot.n > 1 else []

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return tuple(
            Column(f"{self.name}_share_of_joint{i + 1}_{j + 1}", _share_unit(robot, j, i), j + 1, self.name)
            for j, i in self._leaks(robot)
        )

    def values(self, robot: Robot, signals: Signals) -> Array:
        return signals.from_model("motor").T[[i for _, i in self._leaks(robot)]]

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        assert signals.torque is not None
        return replace(signals, torque=signals.torque + signals.torque @ self._mixing(robot, theta).T)

    def numpy_source(self, robot: Robot, theta: Array) -> str:
        return f"motor @ {array_source(self._mixing(robot, theta).T)}"

    def told_in_words(self, robot: Robot, values: Array) -> str:
        """The largest shares of each channel, in words."""
        shares: dict[int, dict[str, dict[int, float]]] = {j: {} for j in self.active(robot)}
        for (j, i), column, x in zip(self._leaks(robot), self.columns(robot), values.tolist(), strict=True):
            shares[j].setdefault(column.unit, {})[i] = x  # a share has others of its unit to be small beside
        return " ".join(
            f"The torque reading of joint {j + 1} also shows {' and '.join(told)}."
            for j, by_unit in shares.items()
            if (told := [words for unit, some in by_unit.items() for words in _largest_in_words(some, unit)])
        )

    def _leaks(self, robot: Robot) -> list[tuple[int, int]]:
        """Each channel (index) that it acts on, with each other joint whose torque it shows."""
        return [(j, i) for j in self.active(robot) for i in range(robot.n) if i != j]

    def _mixing(self, robot: Robot, theta: Array) -> Array:
        """Shares (n, n) of the joints' torques in each channel, beside its own."""
        mixing = np.zeros((robot.n, robot.n))
        for (j, i), share in zip(self._leaks(robot), theta.tolist(), strict=True):
            mixing[j, i] = share
        return mixing


def _largest_in_words(shares: dict[int, float], unit: str) -> list[str]:
    """The largest of some ``shares`` of joints (indices) in one channel, two at most."""
    order = sorted(shares, key=lambda i: -abs(shares[i]))[:2]
    told = {i: shares[i] for i in order if abs(shares[i]) > TOLD * abs(shares[order[0]])}
    size = {i: f"{100 * x:.2g} %" if unit == "1" else f"{x:.2g} {unit}" for i, x in told.items()}
    return [f"{size[i]} of what joint {i + 1} carries" for i in told]


def _share_unit(robot: Robot, of: int, by: int) -> str:
    """The unit of a share of one joint's torque in the channel of another."""
    slides, other = (robot.joints[k].kind == "prismatic" for k in (of, by))
    if slides == other:
        return "1"
    return "N/(N m)" if slides else "N m/N"


@dataclass(frozen=True)
class LeakingChannels(TorqueConstant):
    """tau_j = tau_m_j + sum_i k_ji tau_m_i: a channel shows a share of every joint's torque, its own among them.

    It is no effect of the catalogue, but what a torque constant is held against: that scales what a joint's own channel shows.
    """

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return tuple(
            Column(f"{self.name}_{j + 1}_of_{i + 1}", self.unit, j + 1, self.name)
            for j in self.active(robot)
            for i in range(robot.n)
        )

    def values(self, robot: Robot, signals: Signals) -> Array:
        return np.tile(signals.from_model("motor").T, (len(self.active(robot)), 1))


@dataclass(frozen=True)
class TorqueOffset(Effect):
    """tau_j = c_j: a constant offset of the measured torque of a joint, in N m.

    Nominal: what holds the joint at zero against a simulator's spring.
    """

    name: ClassVar[str] = "torque_offset"
    unit: ClassVar[str] = "N m"
    family: ClassVar[Family] = Family.MEASUREMENT
    acts_on: ClassVar = "measurement"
    formulas: ClassVar[tuple[str, ...]] = ("np.ones_like(v)",)
    signature: ClassVar[str] = "constant at any speed"
    mistaken_for: ClassVar[str] = "friction_asymmetry: move at two speeds in both directions"

    def values(self, robot: Robot, signals: Signals) -> Array:
        return np.ones((len(self.active(robot)), len(signals.time)))

    def nominal(self, robot: Robot) -> Array:
        return robot.spring_offset[self.active(robot)]


@dataclass(frozen=True)
class TorqueDelay(Effect):
    """tau_j(t) = tau_m_j(t - d_j), to first order -d_j dtau_m_j/dt; d in s, positive where the torque of joint j is late.

    tau_m is the model's torque without measurement effects. A first-order low-pass filter of the channel with time constant d is the same
    to first order.
    """

    name: ClassVar[str] = "torque_delay"
    unit: ClassVar[str] = "s"
    family: ClassVar[Family] = Family.MEASUREMENT
    acts_on: ClassVar = "measurement"
    pointwise: ClassVar[bool] = False
    needs_model: ClassVar[bool] = True
    signature: ClassVar[str] = "the whole torque of one joint lags by the same time at any speed"
    mistaken_for: ClassVar[str] = (
        "presliding_hysteresis: friction alone lags there, by a distance; rotor_inertia: joints without gravity torque"
    )

    def around(self, robot: Robot, signals: Signals, samples: slice) -> slice:
        return _with_neighbours(signals, samples)

    def values(self, robot: Robot, signals: Signals) -> Array:
        return _earlier(signals.from_model("motor"), signals.rate)[self.active(robot)]

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        delays = np.zeros(robot.n)
        delays[self.active(robot)] = theta
        return _delayed(signals, delays)

    def in_words(self, robot: Robot, theta: Array) -> str:
        return " ".join(_delay_in_words(j + 1, float(d)) for j, d in zip(self.active(robot), theta, strict=True))


@dataclass(frozen=True)
class LateFriction(TorqueDelay):
    """tau_j = tau_m_j - d_j dF_j/dt: only what the model's torque is beside inertia and gravity, F, comes late.

    It is no effect of the catalogue, but what a late channel is held against: friction that builds up over a distance lags, too.
    """

    def values(self, robot: Robot, signals: Signals) -> Array:
        inertial = signals.from_model("load") + signals.from_model("rotors") * signals.a
        beside = signals.from_model("motor") - inertial
        return _earlier(beside, signals.rate)[self.active(robot)]


def _delay_in_words(joint: int, delay: float) -> str:
    """What a channel that is late or early by a delay [s] means."""
    size = f"{1000 * abs(delay):.2g} ms"
    if delay < 0:
        return f"The torque reading of joint {joint} comes {size} before its motion: its position or velocity is late."
    return (
        f"The torque reading of joint {joint} comes {size} after its motion, or passes a filter that the others do not."
    )


@dataclass(frozen=True)
class TimeDelay(Effect):
    """tau(t) = tau_m(t - d), to first order -d dtau_m/dt, one d for all joints; d in s, positive where torque is late."""

    name: ClassVar[str] = "time_delay"
    unit: ClassVar[str] = "s"
    family: ClassVar[Family] = Family.MEASUREMENT
    scope: ClassVar[Scope] = Scope.WHOLE_ARM
    acts_on: ClassVar = "measurement"
    pointwise: ClassVar[bool] = False
    needs_model: ClassVar[bool] = True
    signature: ClassVar[str] = "the same delay in every joint"
    mistaken_for: ClassVar[str] = "joint_elasticity: its delay grows with the inertia behind the joint"

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return (Column(self.name, self.unit, 1, self.name),)

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        return every_joint_pattern(robot.n, 1)

    def around(self, robot: Robot, signals: Signals, samples: slice) -> slice:
        return _with_neighbours(signals, samples)

    def values(self, robot: Robot, signals: Signals) -> Array:
        return _earlier(signals.from_model("motor"), signals.rate)

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        return _delayed(signals, np.full(robot.n, theta[0]))


def _with_neighbours(signals: Signals, samples: slice) -> slice:
    """Some samples and one on either side, from which a derivative in time is taken."""
    return slice(max(0, samples.start - 1), min(len(signals.time), samples.stop + 1))


def _earlier(torque: Array, rate: float) -> Array:
    """By how much (n, N) [N m/s|N/s] a torque (N, n) was larger a little earlier, for each second of delay."""
    return -np.gradient(torque, 1 / rate, axis=0).T


def _delayed(signals: Signals, delays: Array) -> Signals:
    """The signals with the torque of each joint as it was a delay (n,) [s] before."""
    assert signals.torque is not None
    late = [np.interp(signals.time - delay, signals.time, x) for delay, x in zip(delays, signals.torque.T, strict=True)]
    return replace(signals, torque=np.column_stack(late))
