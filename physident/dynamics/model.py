"""A model: a robot, a tuple of effects, and a value for each of their parameters."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.dry_sign import SHARPEST, SMOOTH_SIGN_SOURCE
from physident.dynamics.inverse_dynamics import gravity_torque, inverse_dynamics
from physident.effects.catalogue import DEFAULT_EFFECTS, described_effects, effect_from_dict, make_effects
from physident.effects.effect import AddedInertia, Column, Effect, array_source
from physident.errors import InputError
from physident.large_arrays import BLOCK, empty, release
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
MAX_PRINTED, MAX_VALUES = 15, 6  # effects of a model, and values of an effect, that its printed form shows
LARGEST = 1e12  # of any parameter in SI units: torques and their squares stay finite


def turning_speeds(robot: Robot, effects: Sequence[Effect]) -> Array | None:
    """The speeds (n,) [rad/s|m/s] over which the dry friction of some effects turns; None where none states them."""
    stated = [widths for effect in effects if (widths := effect.transition(robot)) is not None]
    return np.max(stated, axis=0) if stated else None


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """Torque of a robot as a sum of effects, tau = sum_e Phi_e(q, v, a) theta_e.

    ``theta`` (p,) are the effects' parameters in sequence, in the units of ``columns``.
    """

    robot: Robot
    effects: tuple[Effect, ...]
    theta: Array

    def __post_init__(self) -> None:
        theta = np.array(self.theta, dtype=float)
        if theta.shape != (len(self.columns),) or not np.isfinite(theta).all():
            raise InputError(f"theta has shape {theta.shape}, expected {len(self.columns)} finite numbers")
        if (beyond := np.flatnonzero(np.abs(theta) > LARGEST)).size:
            column, value = self.columns[beyond[0]], theta[beyond[0]]
            raise InputError(f"{column.name} is {value:g} {column.unit}, expected a size below {LARGEST:g}")
        theta.setflags(write=False)
        object.__setattr__(self, "theta", theta)

    @staticmethod
    def nominal(robot: Robot, effects: Iterable[str | Effect] = DEFAULT_EFFECTS) -> Model:
        """The model with the parameters of the robot's description, zero where the description has none."""
        effects = make_effects(effects)
        return Model(robot, effects, np.concatenate([effect.nominal(robot) for effect in effects]))

    @staticmethod
    def described(robot: Robot) -> Model:
        """The model of a simulation from the robot's description: rigid links, and what a simulator's file adds to them."""
        added = described_effects(robot) if robot.joint_dynamics is not None else ()
        return Model.nominal(robot, ["rigid_body", *added])

    def stepped(self) -> Model:
        """The model as the described simulation computes it in steps of time, which its recordings show; else the same."""
        if self.robot.joint_dynamics is None:
            return self
        return replace(self, effects=tuple(effect.stepped(self.robot) for effect in self.effects))

    @property
    def columns(self) -> tuple[Column, ...]:
        """Name, unit and joint of each parameter, in the order of ``theta``."""
        return tuple(column for effect in self.effects for column in effect.columns(self.robot))

    def __repr__(self) -> str:
        rows = [f"Model of {self.robot.name}: {self.robot.n} joints, {len(self.theta)} parameters"]
        for effect, values in self.effect_parameters()[:MAX_PRINTED]:
            units = {column.unit for column in effect.columns(self.robot)}
            shown = ", ".join(f"{value:.4g}" for value in values[:MAX_VALUES]) + (
                ", ..." if len(values) > MAX_VALUES else ""
            )
            unit = f" {units.pop()}" if len(units) == 1 else ""
            rows.append(f"  {effect.name}: {shown}{unit}")
        more = len(self.effects) - MAX_PRINTED
        return "\n".join([*rows, *([f"  and {more} more effects"] if more > 0 else [])])

    def parameters(self, effect: str) -> Array:
        """The parameters of one effect by name; raises InputError where the model has no such effect."""
        chosen = [i for i, column in enumerate(self.columns) if column.effect == effect]
        if not chosen:
            names = ", ".join(e.name for e in self.effects)
            raise InputError(f"the model has no effect {effect!r}, expected one of {names}")
        return self.theta[chosen]

    def effect_parameters(self) -> list[tuple[Effect, Array]]:
        """Each effect with its parameters (k,)."""
        sizes = [len(effect.columns(self.robot)) for effect in self.effects]
        return list(zip(self.effects, np.split(self.theta, np.cumsum(sizes)[:-1]), strict=True))

    def source_of(self, effect: Effect, theta: Array) -> str | None:
        """The torque of one of its effects with parameters (k,) as a NumPy expression, whose dry friction turns over the speeds of the
        model's; None where the effect has none."""
        source, stated = effect.numpy_source(self.robot, theta), turning_speeds(self.robot, self.effects)
        if source is None or stated is None:
            return source
        widths = array_source(np.maximum(stated, SHARPEST))
        return source.replace(SMOOTH_SIGN_SOURCE, f"np.tanh(v / {widths})")

    def added_inertia(self) -> AddedInertia:
        """Inertia of the arm as the sum over the effects: links (10 n,) [kg, kg m, kg m^2], rotors, change of gravity."""
        n = self.robot.n
        links, armature, gravity = np.zeros(10 * n), np.zeros(n), np.zeros(3)
        for effect, theta in self.effect_parameters():
            if (added := effect.inertia(self.robot, theta)) is not None:
                links, armature, gravity = links + added.links, armature + added.armature, gravity + added.gravity
        x, y, z = gravity.tolist()
        return AddedInertia(links, armature, (x, y, z))

    def refer(self, signals: Signals) -> Signals:
        """The signals with the torques this model predicts for their motion, which the columns of some effects need.

        ``links`` and ``rotors``: the inertias in force; ``load``: the torque of the links' inertia and gravity, which the gears carry - a
        rotor turns before its gear; ``motor``: the torque of all effects but the measurement effects. Raises InputError where an effect needs a contiguous recording.
        """
        stated = turning_speeds(self.robot, self.effects)
        signals = signals if stated is None else replace(signals, transition=stated)
        if len(signals.q) <= BLOCK or not all(effect.pointwise for effect in self.effects):
            return self._referred(signals)
        load, motor = empty(signals.q.shape), empty(signals.q.shape)
        for samples in signals.blocks():
            part = self._referred(signals.part(samples))
            load[samples], motor[samples] = part.from_model("load"), part.from_model("motor")
            release()
        added = self.added_inertia()
        return replace(signals, links=added.links, rotors=added.armature, load=load, motor=motor)

    def _referred(self, signals: Signals) -> Signals:
        """The same for signals that are worked on at once."""
        added = self.added_inertia()
        load = inverse_dynamics(self.robot, added.links, signals.q, signals.v, signals.a)
        if any(added.gravity):
            load = load + gravity_torque(self.robot, added.links, signals.q, np.array(added.gravity))
        referred = replace(signals, links=added.links, rotors=added.armature, load=load)
        motor = (load + added.armature * signals.a).T.copy()
        for effect, theta in self.effect_parameters():
            if effect.acts_on != "measurement" and effect.inertia(self.robot, theta) is None:
                self._add(motor, effect, theta, referred)
        return replace(referred, motor=motor.T)

    def torque(self, signals: Signals) -> Array:
        """Joint torques (N, n) [N m|N] that the model predicts to be measured at every sample, unfiltered."""
        return self.measured_torque(self.refer(signals))

    def measured_torque(self, referred: Signals) -> Array:
        """Joint torques (N, n) [N m|N] that the model predicts to be measured, from the signals of ``refer``."""
        assert referred.motor is not None
        tau = referred.motor.T.copy()
        for effect, theta in self.effect_parameters():
            if effect.acts_on == "measurement":
                self._add(tau, effect, theta, referred)
        return tau.T

    def _add(self, tau: Array, effect: Effect, theta: Array, signals: Signals) -> None:
        """Add the torque of one effect to ``tau`` (n, N), segment by segment."""
        pattern = effect.pattern(self.robot)
        for samples in signals.segments:
            values = effect.values(self.robot, signals.part(samples))
            for (row, column), entries in zip(pattern, values, strict=True):
                tau[row, samples] += theta[column] * entries

    def as_dict(self) -> dict[str, Any]:
        """Robot, effects and values as plain numbers and texts for JSON."""
        return {
            "robot": self.robot.as_dict(),
            "effects": [effect.as_dict() for effect in self.effects],
            "parameters": [
                {"name": c.name, "joint": c.joint, "unit": c.unit, "value": float(value)}
                for c, value in zip(self.columns, self.theta, strict=True)
            ],
        }

    @staticmethod
    def from_dict(data: dict[str, Any]) -> Model:
        """The model that ``as_dict`` described."""
        robot = Robot.from_dict(data["robot"])
        effects = make_effects(effect_from_dict(effect) for effect in data["effects"])
        model = Model(robot, effects, np.array([parameter["value"] for parameter in data["parameters"]]))
        for column, parameter in zip(model.columns, data["parameters"], strict=True):
            if column.name != parameter["name"]:
                raise InputError(
                    f"parameter is {parameter['name']!r}, expected {column.name!r} at this place; identify it again"
                )
        return model
