"""The changes of an arm that a fleet watches: what wears, loosens, or is forgotten."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.catalogue import CATALOGUE, make_effects
from physident.effects.classification import Family
from physident.effects.effect import Effect
from physident.fleet.lost_motion import LostMotion

Array = NDArray[np.float64]
WORDS = {
    "friction": "friction of joint {joint}",
    "viscous_friction": "friction of joint {joint} (viscous part)",
    "coulomb_friction": "friction of joint {joint} (Coulomb part)",
    "torque_constant": "torque constant of joint {joint}",
    "torque_offset": "offset of the torque of joint {joint}",
    "lost_motion": "lost motion in the transmission of joint {joint} (backlash)",
    "joint_elasticity": "elasticity of the transmission of joint {joint}",
    "payload": "payload",
    "gravity_tilt": "mounting of the base (tilt)",
}
LAWS = ("stribeck_friction", "load_dependent_friction")  # that a baseline may have beside these
FIRST_MOMENTS = 4  # parameters of a payload that are fitted: mass and first moments; its own inertia is small


@dataclass(frozen=True, eq=False)
class Candidate:
    """A change that may have happened alone: its ``effect``, the ``joint`` (from 1), and each of its k parameters: ``names``,
    ``units``, the value of the ``baseline`` (k,), and its column as a sum of the watched effects' columns, ``weights`` (p, k)."""

    effect: str
    joint: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    baseline: Array
    weights: Array


def words_of(effect: str, joint: int) -> str:
    """What changes, in words."""
    return WORDS[effect].format(joint=joint)


def watched_effects(model: Model) -> tuple[Effect, ...]:
    """The effects whose parameters are watched, and other laws of friction of an arm's ``model``, which are watched as a whole."""
    others = [effect for effect in model.effects if effect.family is Family.FRICTION and effect.name not in WORDS]
    return (*make_effects([name for name in WORDS if name in CATALOGUE]), LostMotion(), *others)


def candidates_of(model: Model, effects: tuple[Effect, ...]) -> list[Candidate]:
    """The candidates among the columns of ``watched_effects``, beside the values of an arm's ``model``."""
    robot = model.robot
    columns = [column for effect in effects for column in effect.columns(robot)]
    known = {column.name: float(value) for column, value in zip(model.columns, model.theta, strict=True)}
    units = np.eye(len(columns))
    groups: dict[tuple[str, int], list[int]] = {}
    for k, column in enumerate(columns):
        if column.effect not in WORDS:
            continue
        groups.setdefault((column.effect, column.joint), []).append(k)
    found = []
    for (effect, joint), places in groups.items():
        places = places[:FIRST_MOMENTS]
        names = tuple(columns[k].name for k in places)
        found.append(
            Candidate(
                effect,
                joint,
                names,
                tuple(columns[k].unit for k in places),
                np.array([known.get(name, 0.0) for name in names]),
                units[:, places],
            )
        )
    friction = {effect.name for effect in effects if effect.family is Family.FRICTION}
    for joint in range(1, robot.n + 1):  # wear and lubrication scale friction as a whole
        places = [k for k, column in enumerate(columns) if column.effect in friction and column.joint == joint]
        whole = sum(known.get(columns[k].name, 0.0) * units[:, [k]] for k in places)
        found.append(Candidate("friction", joint, (f"friction_{joint}",), ("1",), np.ones(1), np.asarray(whole)))
    return found
