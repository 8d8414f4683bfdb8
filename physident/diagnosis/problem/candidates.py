"""What a diagnosis may name: every effect of the catalogue on every joint, at every shape of its grid; and placebos."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import JointRows, Regressor
from physident.effects.catalogue import CATALOGUE
from physident.effects.effect import Effect, Shape
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
WHOLE_ARM = ("payload", "gravity_tilt", "time_delay", "contact")
NOT_JOINT_BY_JOINT = ("rigid_body", "contact")  # its changes are payload and link_inertia; contact is scanned for
FRICTION = (
    "viscous_friction", "coulomb_friction", "friction_asymmetry", "stribeck_friction", "nonlinear_viscous_friction",
    "load_dependent_friction", "presliding_hysteresis", "warm_up", "coupled_friction",
)  # fmt: skip
WARMED = 1.0  # K: a temperature that changes by less explains nothing
PLACEBOS = ("placebo_reversed", "placebo_random")


@dataclass(frozen=True)
class Option:
    """One concrete effect, its shape set, and where its columns stand in the evidence."""

    effect: Effect | None
    columns: tuple[int, ...]


@dataclass(frozen=True)
class Candidate:
    """An effect on some joints (from 1; empty: the whole arm) with an option for each shape of its grid."""

    name: str
    joints: tuple[int, ...]
    options: tuple[Option, ...]

    @property
    def placebo(self) -> bool:
        """Whether it is a column that cannot be a cause, there to test the gate."""
        return self.name in PLACEBOS

    @property
    def size(self) -> int:
        """How many numbers it may choose: columns, and one for a shape that is searched."""
        return len(self.options[0].columns) + (len(self.options) > 1)

    @property
    def key(self) -> tuple[str, tuple[int, ...]]:
        """Name and joints, which no two candidates share."""
        return self.name, self.joints


@dataclass(frozen=True)
class AcceptedEffect:
    """A candidate that was accepted, and its concrete effect with the shape it was found to have."""

    candidate: Candidate
    effect: Effect


def candidate_effects(model: Model, signals: Sequence[Signals]) -> list[tuple[str, tuple[int, ...], list[Effect]]]:
    """Name, joints and concrete effects of every candidate but contact, for a model and the signals to explain."""
    found = []
    for name in CATALOGUE:
        if name in NOT_JOINT_BY_JOINT:
            continue
        for joints in places(name, model.robot.n):
            own = _own(model, name, joints)
            found.append((name, joints, [own] if own is not None else _shaped(model.robot, name, joints, signals)))
    return found


def places(name: str, n: int) -> list[tuple[int, ...]]:
    """The joints an effect can be on: none for the whole arm, neighbours for coupling, links 1 to n - 1."""
    if name in WHOLE_ARM:
        return [()]
    if name == "coupled_friction":
        return [(j, j + 1) for j in range(1, n)]
    return [(j,) for j in range(1, n if name == "link_inertia" else n + 1)]


def grid(robot: Robot, name: str, joints: tuple[int, ...], shape: Shape) -> tuple[float, ...]:
    """The shape's grid; ripple also at the orders of the motor and of the wave generator, where the gear is known."""
    if name != "torque_ripple" or robot.drives is None:
        return shape.grid
    ratio = robot.drives[joints[0] - 1].gear_ratio
    return (*shape.grid, *(k for k in (ratio, 2 * ratio) if k not in shape.grid))


def _own(model: Model, name: str, joints: tuple[int, ...]) -> Effect | None:
    """The model's own effect of that name, on these joints alone: then the candidate is a change of its value."""
    for effect in model.effects:
        if effect.name != name:
            continue
        if not joints or name == "coupled_friction":
            if effect.joints in (None, joints):
                return effect if not joints else replace(effect, joints=joints)
            continue
        active = effect.active(model.robot)
        if joints[0] - 1 not in active:
            continue
        at = active.index(joints[0] - 1)
        one = {
            s.field: (values[at] if len(values) > 1 else values[0],)
            for s in effect.shapes
            if (values := getattr(effect, s.field)) is not None
        }
        return replace(effect, joints=joints, **one)
    return None


def _shaped(robot: Robot, name: str, joints: tuple[int, ...], signals: Sequence[Signals]) -> list[Effect]:
    """The effect at every shape of its grid; warm-up also by measured temperature."""
    cls = CATALOGUE[name]
    where = joints or None
    if not cls.shapes:
        return [cls(joints=where)]
    (shape,) = cls.shapes
    values = grid(robot, name, joints, shape)
    if name == "warm_up":  # what takes longer than a recording is, in it, another constant value of friction
        longest = max(float(one.time[-1] - one.time[0]) for one in signals)
        values = tuple(value for value in values if value <= longest) or values[:1]
    effects = [cls(joints=where, **{shape.field: (value,)}) for value in values]
    warmth = [one.temperature for one in signals]
    if name == "warm_up" and all(w is not None and np.ptp(w, axis=0).max() > WARMED for w in warmth):
        start = float(np.mean([w[0].mean() for w in warmth if w is not None]))
        effects.append(replace(cls(joints=where), reference_temperature=round(start, 1)))
    return effects


def with_placebos(regressor: Regressor, seed: int) -> tuple[Regressor, list[Candidate]]:
    """The regressor with two columns more for each joint that no arm can have: the joint's dry friction played backwards,
    and smooth noise with the spectrum of the joint's torque."""
    from physident.diagnosis.statistics.surrogates import phase_randomised

    p, n = len(regressor.columns), len(regressor.joints)
    noise = phase_randomised(regressor.torque, regressor.segment, 1, seed)[:, :, 0]
    joints, placebos = [], []
    for j, rows in enumerate(regressor.joints):
        dry = [k for k, c in enumerate(rows.columns) if regressor.columns[c].name == f"coulomb_friction_{j + 1}"]
        forward = rows.values[:, dry[-1]]
        backward = np.concatenate(
            [forward[regressor.segment == s][::-1] for s in np.unique(regressor.segment)]
        )  # segments are consecutive
        own = (p + 2 * j, p + 2 * j + 1)
        values = np.column_stack([rows.values, backward, noise[:, j]]) * 1.0
        values[~regressor.counted[:, j]] = 0.0
        joints.append(JointRows(np.append(rows.columns, own), values))
        placebos += [Candidate(name, (j + 1,), (Option(None, (at,)),)) for name, at in zip(PLACEBOS, own, strict=True)]
    dummy = regressor.columns[-1]
    return replace(regressor, columns=regressor.columns + (dummy,) * (2 * n), joints=tuple(joints)), placebos
