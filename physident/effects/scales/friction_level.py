"""Friction that differs on all joints at once, by one share, as where an arm is colder than it was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from physident.effects.classification import Family, JointTerm
from physident.effects.effect import Array, Effect, array_source
from physident.effects.friction import PRESLIDING, CoulombFriction
from physident.effects.kinds_of_values import OneByOne
from physident.effects.scales.shared_scale import SharedScale, sized
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

SPEEDS = (0.0, *(float(x) for x in np.geomspace(0.01, 1.0, 15)))  # of a joint's largest: friction bends at low speed
STRAIGHT = 1e-6  # of a joint's dry friction: a curve that bends less is none
FASTEST = 3.0  # rad/s, of a joint whose description has no limit


@dataclass(frozen=True)
class FrictionLevel(SharedScale, OneByOne):
    """tau_j = (s + d_j / 100) (Fc_j sgn v_j + Fv_j v_j + F_j(|v_j|) sgn v_j): the friction of all joints differs by a share s, without a
    unit, and that of a joint by d_j per cent more; no joint has less than no friction.

    ``coulomb`` Fc [N m], ``viscous`` Fv [N m s/rad] and ``beyond`` F [N m], at ``speeds`` [rad/s], are the friction that it scales, one value or
    one a joint, and of F a row a joint, one after the other; a diagnosis takes those of the model that it asks. ``smoothing`` [rad/s] and
    ``presliding`` [rad|m] are those of ``CoulombFriction``. An arm that is warmer than it was has less friction in every joint. Source:
    Bittencourt and Gunnarsson, "Static friction in a robot joint - modeling and identification of load and temperature effects" (2012), sec. 4.
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

    def _beyond(self, robot: Robot, v: Array) -> Array:
        """The part (n, N) that is no straight line, at speeds (n, N)."""
        if not self.speeds:
            return np.zeros(v.shape)
        return np.array([np.interp(np.abs(one), *row) for one, *row in zip(v, *self._curve(robot), strict=True)])

    def _of(self, robot: Robot, sign: Array, v: Array) -> Array:
        """Structural non-zeros (E, N) by the sign and the velocity (n, N) of each joint."""
        coulomb, viscous = self._sizes(robot)
        return self.of_part(robot, (coulomb[:, None] + self._beyond(robot, v)) * sign + viscous[:, None] * v)

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
        speeds = _speeds(robot)
        beyond = np.zeros(speeds.shape)
        for effect, theta in present:
            if isinstance(effect, cls):
                parts = (size * effect.shares(robot, theta) for size in effect._sizes(robot))
                coulomb, viscous = (one + more for one, more in zip((coulomb, viscous), parts, strict=True))
                beyond += effect._beyond(robot, speeds) * effect.shares(robot, theta)[:, None]
                continue
            terms = effect.joint_terms(robot, theta)
            if terms is None:
                beyond += _friction_of(robot, effect, theta, speeds)
            for term in (terms or ()) if effect.family is Family.FRICTION else ():
                joints = list(term.joints)
                coulomb[joints] += term.dry or 0.0
                viscous[joints] += term.damping or 0.0
            if isinstance(effect, CoulombFriction):
                presliding, own = effect.presliding, effect.transition(robot)
                widths = widths if own is None else np.maximum(widths, own)
        coulomb, viscous, beyond = _apart(coulomb, viscous, speeds, beyond)
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

    def told_in_words(self, robot: Robot, values: Array) -> str:
        shares, joints = values[values != 0] / 100, np.flatnonzero(values) + 1
        if not len(joints):
            return ""
        (size, way), part = sized(shares), self._part
        if len(joints) < len(values):
            where = f"joint{'s' if len(joints) > 1 else ''} {', '.join(map(str, joints))}"
            return f"The {part}friction of {where} is {size} {way}{' ' if way else ''}than the model's; that of the others may be as before."
        if not way:
            return f"The {part}friction of the joints is {size} than the model's."
        why = "a colder" if way == "higher" else "a warmer"
        return f"The {part}friction of all joints is {size} {way} than the model's, as in {why} arm."

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


def _speeds(robot: Robot) -> Array:
    """Speeds (n, S) of each joint at which its friction is read; a description may give no limit."""
    limits = zip(robot.velocity_limit, robot.radian, strict=True)
    fastest = [v if np.isfinite(v) and v > 0 else FASTEST * radian for v, radian in limits]
    return np.outer(fastest, SPEEDS)


def _friction_of(robot: Robot, effect: Effect, theta: Array, speeds: Array) -> Array:
    """The friction (n, S) of an effect at the speeds of each joint, less what has no direction, as an offset."""
    result, owner = np.zeros(speeds.shape), np.array([column.joint - 1 for column in effect.columns(robot)])
    for j in set(owner.tolist()):
        result[j] = (
            (theta * (owner == j)) @ (effect.friction(robot, speeds[j]) - effect.friction(robot, -speeds[j])) / 2
        )
    # a law's own sign turns over some width; here all turn as dry friction does
    result[:, 0] = result[:, 1] - (result[:, 2] - result[:, 1]) * SPEEDS[1] / (SPEEDS[2] - SPEEDS[1])
    return result


def _apart(coulomb: Array, viscous: Array, speeds: Array, beyond: Array) -> tuple[Array, Array, Array]:
    """Coulomb and viscous friction (n,), and what is neither (n, S): what a curve has at every speed is dry, a straight line stays in the
    curve, and all together hold the joint back."""
    coulomb = coulomb + np.maximum(beyond.min(axis=1), 0.0)
    beyond = beyond - np.maximum(beyond.min(axis=1, keepdims=True), 0.0)
    bends = np.ptp(beyond, axis=1) > STRAIGHT * np.abs(coulomb)
    coulomb = np.maximum(coulomb, 0.0)
    curve = np.maximum(beyond + viscous[:, None] * speeds, -coulomb[:, None])
    return coulomb, np.where(bends, 0.0, np.maximum(viscous, 0.0)), np.where(bends[:, None], curve, 0.0)
