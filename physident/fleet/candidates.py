"""The changes of an arm that a fleet watches: what wears, loosens, or is forgotten."""

from __future__ import annotations

from dataclasses import dataclass

from physident.effects.catalogue import make_effects
from physident.effects.effect import Effect
from physident.robots.robot import Robot

OFFSET = "torque_offset"  # fitted along and never reported: it follows the temperature of the electronics
WORDS = {
    "viscous_friction": "friction of joint {joint} (viscous)",
    "coulomb_friction": "friction of joint {joint} (Coulomb)",
    "torque_constant": "torque constant of joint {joint}",
    "joint_elasticity": "lost motion in the transmission of joint {joint} (backlash or elasticity)",
    "payload": "payload",
    "gravity_tilt": "mounting of the base (tilt)",
}
FIRST_MOMENTS = 4  # parameters of a payload that are fitted: mass and first moments; its own inertia is small


@dataclass(frozen=True)
class Candidate:
    """A change that may have happened alone: its ``effect``, the ``joint`` (from 1), and its columns (from 0)."""

    effect: str
    joint: int
    columns: tuple[int, ...]

    @property
    def words(self) -> str:
        """What changes, in words."""
        return WORDS[self.effect].format(joint=self.joint)


def watched_effects(robot: Robot) -> tuple[Effect, ...]:
    """The effects whose parameters are watched, and the offset that is fitted along."""
    return make_effects([*WORDS, OFFSET])


def candidates_of(robot: Robot, effects: tuple[Effect, ...]) -> tuple[list[Candidate], list[int]]:
    """The candidates among the columns of ``watched_effects``, and the columns (from 0) that are fitted along with each."""
    found: list[Candidate] = []
    along: list[int] = []
    at = 0
    for effect in effects:
        columns = effect.columns(robot)
        places = range(at, at + len(columns))
        at += len(columns)
        if effect.name == OFFSET:
            along += places
        elif effect.joints is None and len({c.joint for c in columns}) == len(columns):
            found += [Candidate(effect.name, c.joint, (k,)) for c, k in zip(columns, places, strict=True)]
        else:
            found.append(Candidate(effect.name, columns[0].joint, tuple(places)[:FIRST_MOMENTS]))
    return found, along
