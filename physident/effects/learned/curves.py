"""One learned curve for each quantity that a joint's torque may depend on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.dry_sign import SHARPEST, SMOOTH_SIGN_SOURCE, WIDEST, sign_of_velocity
from physident.effects.classification import Variable
from physident.effects.effect import Array, array_source
from physident.effects.learned.curve import LearnedCurve
from physident.effects.thermal import NOTICEABLE_WARMING
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

COMPARED = 500  # times since the starts of recordings
ONE_MOTION = 0.1  # of a position's variance; two motions that have nothing in common are apart by twice that variance


@dataclass(frozen=True)
class LearnedPosition(LearnedCurve):
    """tau_j = f_j(q_j): cables, springs, cogging; f in N m, it repeats with each turn of a joint that turns freely."""

    name: ClassVar[str] = "learned_position"
    label: ClassVar[str] = "a torque that depends on position"
    variable: ClassVar[Variable | None] = "position"
    signature: ClassVar[str] = "a curve over position that no law of the catalogue has"
    mistaken_for: ClassVar[str] = "torque_ripple or joint_spring: move through the joint's whole range"
    middle: ClassVar[tuple[float, float]] = (-np.pi, np.pi)

    def quantity(self, signals: Signals) -> Array | None:
        return signals.q

    def quantity_source(self, robot: Robot) -> str:
        return "q"

    def circles(self, robot: Robot) -> NDArray[np.bool_]:
        joints = self.active(robot)
        turns = np.array([robot.joints[j].kind == "revolute" for j in joints], dtype=bool)
        return turns & ~np.isfinite(robot.lower[joints]) & ~np.isfinite(robot.upper[joints])


@dataclass(frozen=True)
class LearnedPositionFriction(LearnedPosition):
    """tau_j = f_j(q_j) sgn v_j: a damaged place of a gear, a seal or a cable that rubs; f in N m.

    ``smoothing`` [rad/s], one value or one a joint, is the speed over which it turns, where it does not turn with the joint's dry
    friction: a place may drag as in oil though all else is dry. Then sgn v is tanh(v / smoothing). ``zero`` [rad], one value or one a
    joint, is a place without such friction: a mean that turned over a speed of its own would be friction over velocity, at every place.
    """

    smoothing: tuple[float, ...] | None = None
    zero: tuple[float, ...] | None = None

    name: ClassVar[str] = "learned_position_friction"
    label: ClassVar[str] = "friction that depends on position"
    signature: ClassVar[str] = "friction that is larger at some positions"
    mistaken_for: ClassVar[str] = "load_dependent_friction: move through one position with two loads"
    dry: ClassVar[bool] = True
    settings_by_joint: ClassVar[tuple[str, ...]] = (*LearnedPosition.settings_by_joint, "smoothing", "zero")
    dependence: ClassVar[str] = "position and opposes the motion"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.smoothing is not None and not (np.isfinite(self.smoothing).all() and min(self.smoothing) > 0):
            raise InputError(f"{self.name}: smoothing is {self.smoothing}, expected positive speeds [rad/s]")
        if self.zero is not None and not np.isfinite(self.zero).all():
            raise InputError(f"{self.name}: zero is {self.zero}, expected positions [rad]")

    @property
    def has_mean(self) -> bool:
        return self.zero is None

    def zeros(self, robot: Robot) -> Array | None:
        return None if self.zero is None else self.shape_values(robot, "zero")

    def weight(self, signals: Signals, joints: Sequence[int]) -> Array:
        if self.smoothing is None:
            return sign_of_velocity(signals, joints)
        return sign_of_velocity(signals, joints, np.broadcast_to(self.smoothing, len(joints)).astype(float))

    def factor_source(self, robot: Robot) -> str:
        if self.smoothing is None:
            return SMOOTH_SIGN_SOURCE
        widths = np.full(robot.n, SHARPEST)
        widths[self.active(robot)] = self.shape_values(robot, "smoothing")
        return f"np.tanh(v / {array_source(np.maximum(widths, SHARPEST))})"


@dataclass(frozen=True)
class LearnedLoad(LearnedCurve):
    """tau_j = f_j(tau_load_j), tau_load the torque of the links' inertia and gravity: what a gear or a counterbalance makes of its load; f in N m."""

    name: ClassVar[str] = "learned_load"
    label: ClassVar[str] = "a torque that depends on the load"
    variable: ClassVar[Variable | None] = "load"
    signature: ClassVar[str] = "a curve over the torque of the links' inertia and gravity"
    mistaken_for: ClassVar[str] = (
        "learned_torque: move both ways under each load, so that friction tells load and torque apart"
    )
    needs_model: ClassVar[bool] = True
    pieces: ClassVar[int] = 12
    quantity_unit: ClassVar[str] = "N m"
    dependence: ClassVar[str] = "the load"
    middle: ClassVar[tuple[float, float]] = (-100.0, 100.0)

    def quantity(self, signals: Signals) -> Array | None:
        return signals.load

    def quantity_source(self, robot: Robot) -> str:
        return "load"

    def torque_at(self, robot: Robot, signals: Signals, state: Array, load: Array) -> Array:
        return self._values(robot, signals, load)


@dataclass(frozen=True)
class LearnedTorque(LearnedLoad):
    """tau_j = f_j(tau_m_j): what a drive or a sensor makes of its torque, such as a dead band or a saturation; f in N m.

    tau_m is the model's torque without measurement effects, friction included.
    """

    name: ClassVar[str] = "learned_torque"
    label: ClassVar[str] = "a measured torque that depends on the torque"
    variable: ClassVar[Variable | None] = "torque"
    acts_on: ClassVar = "measurement"
    signature: ClassVar[str] = "a curve over the torque of the drive"
    mistaken_for: ClassVar[str] = "torque_constant: a straight line"
    dependence: ClassVar[str] = "the torque of the drive"

    def quantity(self, signals: Signals) -> Array | None:
        return signals.motor

    def quantity_source(self, robot: Robot) -> str:
        return "motor"

    def at_reversals(self, robot: Robot) -> TorqueAtReversals:
        """The same curve while the joints are so slow that any dry friction of theirs may be turning."""
        return TorqueAtReversals(**vars(self), slow=tuple((WIDEST * robot.radian[self.active(robot)]).tolist()))


@dataclass(frozen=True)
class TorqueAtReversals(LearnedTorque):
    """tau_j = f_j(tau_m_j) (1 - abs(tanh(v_j / slow_j))): a curve over the torque that acts about a reversal, and nowhere else; ``slow`` in rad/s.

    It is no effect of the catalogue, but what a curve over the torque is held against: at a reversal the torque passes values that it has at no
    other time, and a curve there stands for how friction turns.
    """

    slow: tuple[float, ...] = ()

    def weight(self, signals: Signals, joints: Sequence[int]) -> Array:
        return 1.0 - np.abs(np.tanh(signals.v.T[list(joints)] / np.array(self.slow)[:, None]))


@dataclass(frozen=True)
class LearnedTemperature(LearnedCurve):
    """tau_j = f_j(T_j) sgn v_j: dry friction over the joint's measured temperature T in degC; f in N m.

    Recordings need a temperature channel; of one without, or whose temperature hardly changes, a diagnosis does not try it.
    """

    name: ClassVar[str] = "learned_temperature"
    label: ClassVar[str] = "friction that depends on temperature"
    variable: ClassVar[Variable | None] = "temperature"
    signature: ClassVar[str] = "friction that follows the temperature along a curve"
    mistaken_for: ClassVar[str] = "warm_up: a straight line; record at more temperatures"
    dry: ClassVar[bool] = True
    needs_temperature: ClassVar[bool] = True
    pieces: ClassVar[int] = 12
    quantity_unit: ClassVar[str] = "degC"
    dependence: ClassVar[str] = "the temperature and opposes the motion"
    middle: ClassVar[tuple[float, float]] = (10.0, 50.0)
    channel: ClassVar[str] = "a temperature channel, temperature_1.. [degC] (in a simulation: sensors with temperature)"

    @classmethod
    def is_shown(cls, signals: Sequence[Signals], joint: int) -> bool:
        found = [one.temperature[:, joint] for one in signals if one.temperature is not None]
        if len(found) < len(signals):
            return False
        return max(float(x.max()) for x in found) - min(float(x.min()) for x in found) > NOTICEABLE_WARMING

    def quantity(self, signals: Signals) -> Array | None:
        return signals.temperature

    def quantity_source(self, robot: Robot) -> str:
        return "temperature"

    def weight(self, signals: Signals, joints: Sequence[int]) -> Array:
        return sign_of_velocity(signals, joints)

    def numpy_source(self, robot: Robot, theta: Array) -> str | None:
        """None: temperature is no argument of the exported function."""
        return None


@dataclass(frozen=True)
class LearnedTime(LearnedCurve):
    """tau_j = f_j(t): what drifts in the same way in every recording, t from its start; f in N m."""

    name: ClassVar[str] = "learned_time"
    label: ClassVar[str] = "a torque that depends on time"
    variable: ClassVar[Variable | None] = "time"
    signature: ClassVar[str] = "a drift that repeats in every recording"
    mistaken_for: ClassVar[str] = "warm_up: friction that drifts changes its sign with the motion"
    pieces: ClassVar[int] = 12
    quantity_unit: ClassVar[str] = "s"
    dependence: ClassVar[str] = "time"
    middle: ClassVar[tuple[float, float]] = (0.0, 100.0)

    @classmethod
    def is_shown(cls, signals: Sequence[Signals], joint: int) -> bool:
        """In two recordings or more, none of which are of one motion: of two that are, one predicts every error of the model in the other
        by its time, and one alone does not show that anything repeats."""
        until = min(float(one.time[-1] - one.origin) for one in signals)
        since = np.linspace(0.0, until, COMPARED)
        q = np.array([np.interp(since, one.time - one.origin, one.q[:, joint]) for one in signals])
        apart = [np.mean((a - b) ** 2) for k, a in enumerate(q) for b in q[:k]]
        return bool(apart) and float(min(apart)) > ONE_MOTION * float(np.var(q))

    def quantity(self, signals: Signals) -> Array | None:
        return np.tile((signals.time - signals.origin)[:, None], signals.q.shape[1])

    def quantity_source(self, robot: Robot) -> str:
        return "(t + 0 * q)"
