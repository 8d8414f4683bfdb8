"""Friction that falls as an arm warms up, within a recording or from one day to another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from physident.dynamics.dry_sign import SMOOTH_SIGN_SOURCE, sign_of_velocity
from physident.effects.classification import (
    Family,
    JointTerm,
    ShapeParameter,
    Variable,
)
from physident.effects.effect import Array, Column, Effect, array_source
from physident.effects.friction import PRESLIDING, CoulombFriction
from physident.effects.shared_scale import SharedScale, sized
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

SPEEDS = (0.0, *(float(x) for x in np.geomspace(0.01, 1.0, 15)))  # of a joint's largest: friction bends at low speed
FASTEST = 3.0  # rad/s, of a joint whose description has no limit
NOTICEABLE_WARMING = 1.0  # K: a temperature that changes by less explains nothing


@dataclass(frozen=True)
class WarmUp(Effect):
    """tau_j = (Wc_j sgn v_j + Wv_j v_j) w, with w = exp(-t / T) over a recording's time t, or w = temperature - T0.

    Wc in N m, Wv in N m s/rad: the additional friction of a cold joint, which fades with ``time_constant`` T [s]. Time
    starts with each recording and includes its gaps. Where ``reference_temperature`` T0 [degC] is given, Wc and Wv are per
    degC instead and recordings need a temperature channel. Source: Bittencourt and Gunnarsson, "Static friction in a
    robot joint - modeling and identification of load and temperature effects" (2012), sec. 4.
    """

    time_constant: tuple[float, ...] | None = None
    reference_temperature: float | None = None

    name: ClassVar[str] = "warm_up"
    unit: ClassVar[str] = "N m, N m s/rad"
    family: ClassVar[Family] = Family.FRICTION
    variable: ClassVar[Variable | None] = "time"
    dry: ClassVar[bool] = True
    shape_parameters: ClassVar = (ShapeParameter("time_constant", "s", (3.0, 6.0, 12.0, 30.0, 100.0, 300.0)),)
    formulas: ClassVar[tuple[str, ...]] = (
        f"{SMOOTH_SIGN_SOURCE} * np.exp(-t / {{time_constant}})",
        "v * np.exp(-t / {time_constant})",
    )
    signature: ClassVar[str] = "friction drifts slowly"
    mistaken_for: ClassVar[str] = "a change between sessions: record the same motion again later in the same session"

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        per = "" if self.reference_temperature is None else "/degC"
        kinds = (("coulomb", f"N m{per}"), ("viscous", f"N m s/rad{per}"))
        return tuple(
            Column(f"{self.name}_{kind}_{j + 1}", robot.joints[j].unit(unit), j + 1, self.name)
            for j in self.active(robot)
            for kind, unit in kinds
        )

    @classmethod
    def search_options(cls, robot: Robot, joints: tuple[int, ...], signals: Sequence[Signals]) -> Sequence[Self]:
        """Time constants up to the longest recording, and the measured temperature where it changes.

        Warming that takes longer than every recording is a constant friction in each of them.
        """
        longest = max(float(recording.time[-1] - recording.time[0]) for recording in signals)
        every = list(super().search_options(robot, joints, signals))
        options = [effect for effect in every if effect.time_constant and effect.time_constant[0] <= longest] or every[
            :1
        ]
        temperatures = [recording.temperature for recording in signals if recording.temperature is not None]
        if len(temperatures) == len(signals) and all(is_warming(temperature) for temperature in temperatures):
            start = float(np.mean([temperature[0].mean() for temperature in temperatures]))
            options.append(replace(cls(joints), reference_temperature=round(start, 1)))
        return options

    def numpy_source(self, robot: Robot, theta: Array) -> str | None:
        """None where it follows a measured temperature, which is no argument of the exported function."""
        return None if self.reference_temperature is not None else super().numpy_source(robot, theta)

    def values(self, robot: Robot, signals: Signals) -> Array:
        active = self.active(robot)
        if self.reference_temperature is None:
            weight = np.exp(-(signals.time - signals.origin) / self.shape_values(robot, "time_constant")[:, None])
        elif signals.temperature is None:
            raise InputError(
                f"{signals.source} has no temperature channel; warm_up with a reference temperature needs temperature_1.. [degC] (in a simulation: sensors with temperature)"
            )
        else:
            weight = signals.temperature.T[active] - self.reference_temperature
        v = signals.v.T[active]
        return np.stack([weight * sign_of_velocity(signals, active), weight * v], axis=1).reshape(-1, len(signals.time))


@dataclass(frozen=True)
class FrictionLevel(SharedScale):
    """tau_j = (s + d_j / 100) (Fc_j sgn v_j + Fv_j v_j + F_j(|v_j|) sgn v_j): the friction of all joints differs by a share s, without a
    unit, and that of a joint by d_j per cent more; no joint has less than no friction.

    ``coulomb`` Fc [N m], ``viscous`` Fv [N m s/rad] and ``beyond`` F [N m], at ``speeds`` [rad/s], are the friction that it scales, one value or
    one a joint, and of F a row a joint, one after the other; a diagnosis takes those of the model that it asks. ``smoothing`` [rad/s] and
    ``presliding`` [rad|m] are those of ``CoulombFriction``. An arm that is warmer than it was has less friction in every joint. Source: as
    ``WarmUp``, sec. 4.
    """

    coulomb: tuple[float, ...] = (1.0,)
    viscous: tuple[float, ...] = (0.0,)
    speeds: tuple[float, ...] = ()
    beyond: tuple[float, ...] = ()
    smoothing: tuple[float, ...] | None = None
    presliding: float = PRESLIDING

    name: ClassVar[str] = "friction_level"
    family: ClassVar[Family] = Family.FRICTION
    passive: ClassVar[bool] = True
    dry: ClassVar[bool] = True
    signature: ClassVar[str] = "the friction of all joints is scaled alike"
    mistaken_for: ClassVar[str] = (
        "viscous_friction, nonlinear_viscous_friction on several joints: record again when the arm is as warm as before"
    )

    @property
    def _dry(self) -> CoulombFriction:
        """The law of its dry part, for one unit on each joint."""
        return CoulombFriction(smoothing=self.smoothing, presliding=self.presliding)

    def _sizes(self, robot: Robot) -> tuple[Array, Array]:
        """Coulomb and viscous friction (n,) that it scales; raises InputError for another number of values."""
        sizes = []
        for field in ("coulomb", "viscous"):
            values = getattr(self, field)
            if len(values) not in (1, robot.n) or not (np.isfinite(values).all() and min(values) >= 0):
                raise InputError(f"{self.name}: {field} is {values}, expected {robot.n} values that are not negative")
            sizes.append(np.broadcast_to(np.array(values, dtype=float), (robot.n,)))
        return sizes[0], sizes[1]

    def _curve(self, robot: Robot) -> tuple[Array, Array]:
        """Speeds and the friction there (n, S) of the part that is no straight line, S = 0 where there is none; raises InputError for
        numbers that make no such rows."""
        speeds, beyond = (np.array(one, dtype=float) for one in (self.speeds, self.beyond))
        if len(speeds) != len(beyond) or len(speeds) % robot.n or not np.isfinite([*speeds, *beyond]).all():
            raise InputError(
                f"{self.name}: speeds and beyond have {len(speeds)} and {len(beyond)} values, expected {robot.n} rows of as many each"
            )
        return speeds.reshape(robot.n, -1), beyond.reshape(robot.n, -1)

    def _of(self, robot: Robot, sign: Array, v: Array) -> Array:
        """Structural non-zeros (E, N) by the sign and the velocity (n, N) of each joint."""
        coulomb, viscous = self._sizes(robot)
        dry = np.broadcast_to(coulomb[:, None], v.shape)
        if self.speeds:
            dry = dry + [np.interp(np.abs(one), *row) for one, *row in zip(v, *self._curve(robot), strict=True)]
        return self.of_part(robot, dry * sign + viscous[:, None] * v)

    def values(self, robot: Robot, signals: Signals) -> Array:
        return self._of(robot, self._dry.values(robot, signals), signals.v.T)

    @property
    def _part(self) -> str:
        """Which part of the friction it scales, in words; empty for all of it."""
        by_speed = any(self.viscous) or any(self.beyond)
        return "viscous " if not any(self.coulomb) else "" if by_speed else "Coulomb "

    @classmethod
    def options_beside(cls, robot: Robot, present: Sequence[tuple[Effect, Array]]) -> Sequence[Self]:
        """The friction of a model's effects joint by joint, and its Coulomb part and what depends on speed alone; none where they have
        none."""
        coulomb, viscous, widths, presliding = np.zeros(robot.n), np.zeros(robot.n), np.zeros(robot.n), PRESLIDING
        curved = []
        for effect, theta in present:
            terms = effect.joint_terms(robot, theta)
            curved += [(effect, theta)] if terms is None else []
            for term in (terms or ()) if effect.family is Family.FRICTION else ():
                joints = list(term.joints)
                coulomb[joints] += term.dry or 0.0
                viscous[joints] += term.damping or 0.0
            if isinstance(effect, CoulombFriction):
                presliding, own = effect.presliding, effect.transition(robot)
                widths = widths if own is None else np.maximum(widths, own)
        coulomb = np.maximum(coulomb, 0.0)
        speeds, beyond = _beyond(robot, curved, coulomb, viscous)
        viscous = np.where(beyond.any(axis=1), 0.0, np.maximum(viscous, 0.0))  # a curve holds a straight line, too
        by_speed = bool(viscous.any() or beyond.any())
        if not (coulomb.any() or by_speed):
            return []
        whole = cls(
            coulomb=tuple(coulomb.tolist()),
            viscous=tuple(viscous.tolist()),
            speeds=tuple(speeds.ravel().tolist()) if beyond.any() else (),
            beyond=tuple(beyond.ravel().tolist()) if beyond.any() else (),
            smoothing=tuple(widths.tolist()) if widths.any() else None,
            presliding=presliding,
        )
        none = (0.0,) * robot.n
        parts = [replace(whole, viscous=none, speeds=(), beyond=()), replace(whole, coulomb=none)]
        return [whole, *parts] if coulomb.any() and by_speed else [whole]

    def in_words(self, robot: Robot, theta: Array) -> str:
        size, way = sized(self.shares(robot, theta))
        if not way:
            return f"The {self._part}friction of the joints is {size} than the model's."
        why = "a colder" if way == "higher" else "a warmer"
        return f"The {self._part}friction of all joints is {size} {way} than the model's, as in {why} arm."

    def state_size(self, robot: Robot) -> int:
        return self._dry.state_size(robot)

    def state_rate(self, robot: Robot, signals: Signals, state: Array) -> Array:
        return self._dry.state_rate(robot, signals, state)

    def torque_at(self, robot: Robot, signals: Signals, state: Array, load: Array) -> Array:
        return self._of(robot, self._dry.torque_at(robot, signals, state, load), signals.v.T)

    def numpy_source(self, robot: Robot, theta: Array) -> str:
        shares = self.shares(robot, theta)
        coulomb, viscous = (size * shares for size in self._sizes(robot))
        source = f"{self._dry.numpy_source(robot, coulomb)} + {array_source(viscous)} * v"
        if not self.speeds:
            return source
        # a line through points is a constant and bends: half of each change of slope times the distance to its point
        speeds, beyond = self._curve(robot)
        slopes = np.diff(beyond, axis=1) / np.diff(speeds, axis=1)
        bends = np.diff(np.pad(slopes, ((0, 0), (1, 1))), axis=1) / 2 * shares[:, None]
        level = array_source((beyond[:, 0] + beyond[:, -1]) / 2 * shares)
        curve = [
            f"{array_source(c)} * np.abs(np.abs(v) - {array_source(at)})"
            for c, at in zip(bends.T, speeds.T, strict=True)
        ]
        return f"{source} + ({self._dry.numpy_source(robot, np.ones(robot.n))}) * ({' + '.join([level, *curve])})"

    def joint_terms(self, robot: Robot, theta: Array) -> tuple[JointTerm, ...] | None:
        if self.beyond:
            return None
        sizes = zip(*(size * self.shares(robot, theta) for size in self._sizes(robot)), strict=True)
        return tuple(JointTerm((j,), damping=float(Fv), dry=float(Fc)) for j, (Fc, Fv) in enumerate(sizes))


def _beyond(
    robot: Robot, curved: Sequence[tuple[Effect, Array]], coulomb: Array, viscous: Array
) -> tuple[Array, Array]:
    """Speeds (n, S) of each joint, and what the friction of some effects there is, with the viscous friction (n,) of joints where it is
    anything; together with their Coulomb friction (n,) it holds the joint back."""
    # a description may give no limit
    fastest = np.array(
        [v if np.isfinite(v) and v > 0 else FASTEST * robot.radian[j] for j, v in enumerate(robot.velocity_limit)]
    )
    speeds, beyond = fastest[:, None] * np.array(SPEEDS), np.zeros((robot.n, len(SPEEDS)))
    for effect, theta in curved:
        owner = [column.joint - 1 for column in effect.columns(robot)]
        for j in sorted(set(owner)):
            own = theta * (np.array(owner) == j)
            # what has no direction, as an offset, is no friction
            beyond[j] += own @ (effect.friction(robot, speeds[j]) - effect.friction(robot, -speeds[j])) / 2
    # a law's own sign turns over some width; here all turn as dry friction does
    beyond[:, 0] = beyond[:, 1] - (beyond[:, 2] - beyond[:, 1]) * SPEEDS[1] / (SPEEDS[2] - SPEEDS[1])
    has = np.any(np.abs(beyond) > 0, axis=1)
    beyond[has] += (viscous[:, None] * speeds)[has]
    return speeds, np.where(has[:, None], np.maximum(beyond, -coulomb[:, None]), 0.0)


def is_warming(temperature: Array) -> bool:
    """Whether any of the joints' temperatures (N, n) [degC] changes enough to explain a change of friction."""
    return bool(np.ptp(temperature, axis=0).max() > NOTICEABLE_WARMING)
