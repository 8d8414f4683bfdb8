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
    """tau_j = (s + d_j / 100) (Fc_j sgn v_j + Fv_j v_j): the friction of all joints differs by a share s, without a unit, and that of a
    joint by d_j per cent more; no joint has less than no friction.

    ``coulomb`` Fc [N m] and ``viscous`` Fv [N m s/rad] are the friction that it scales, one value or one a joint; a diagnosis takes
    those of the model that it asks. ``smoothing`` [rad/s] and ``presliding`` [rad|m] are those of ``CoulombFriction``. An arm that is warmer than it was
    has less friction in every joint. Source: as ``WarmUp``, sec. 4.
    """

    coulomb: tuple[float, ...] = (1.0,)
    viscous: tuple[float, ...] = (0.0,)
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

    def _of(self, robot: Robot, sign: Array, v: Array) -> Array:
        """Structural non-zeros (E, N) by the sign and the velocity (n, N) of each joint."""
        coulomb, viscous = self._sizes(robot)
        return self.of_part(robot, coulomb[:, None] * sign + viscous[:, None] * v)

    def values(self, robot: Robot, signals: Signals) -> Array:
        return self._of(robot, self._dry.values(robot, signals), signals.v.T)

    @property
    def _part(self) -> str:
        """Which part of the friction it scales, in words; empty for all of it."""
        return "viscous " if not any(self.coulomb) else "Coulomb " if not any(self.viscous) else ""

    @classmethod
    def options_beside(cls, robot: Robot, present: Sequence[tuple[Effect, Array]]) -> Sequence[Self]:
        """The friction that a model's effects state joint by joint, and its Coulomb and its viscous part alone; none where they
        state none."""
        coulomb, viscous, widths, presliding = np.zeros(robot.n), np.zeros(robot.n), np.zeros(robot.n), PRESLIDING
        for effect, theta in present:
            for term in (effect.joint_terms(robot, theta) or ()) if effect.family is Family.FRICTION else ():
                joints = list(term.joints)
                coulomb[joints] += term.dry or 0.0
                viscous[joints] += term.damping or 0.0
            if isinstance(effect, CoulombFriction):
                presliding, own = effect.presliding, effect.transition(robot)
                widths = widths if own is None else np.maximum(widths, own)
        if not (coulomb.any() or viscous.any()):
            return []
        smoothing = tuple(widths.tolist()) if widths.any() else None
        parts = [(coulomb, viscous), (coulomb, 0 * viscous), (0 * coulomb, viscous)]
        return [
            cls(
                coulomb=tuple(np.maximum(dry, 0.0).tolist()),
                viscous=tuple(np.maximum(damping, 0.0).tolist()),
                smoothing=smoothing,
                presliding=presliding,
            )
            for dry, damping in (parts if coulomb.any() and viscous.any() else parts[:1])
        ]

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
        coulomb, viscous = (size * self.shares(robot, theta) for size in self._sizes(robot))
        return f"{self._dry.numpy_source(robot, coulomb)} + {array_source(viscous)} * v"

    def joint_terms(self, robot: Robot, theta: Array) -> tuple[JointTerm, ...]:
        sizes = zip(*(size * self.shares(robot, theta) for size in self._sizes(robot)), strict=True)
        return tuple(JointTerm((j,), damping=float(Fv), dry=float(Fc)) for j, (Fc, Fv) in enumerate(sizes))


def is_warming(temperature: Array) -> bool:
    """Whether any of the joints' temperatures (N, n) [degC] changes enough to explain a change of friction."""
    return bool(np.ptp(temperature, axis=0).max() > NOTICEABLE_WARMING)
