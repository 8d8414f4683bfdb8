"""The second open world: arms, motions, instruments and causes that were written apart from the first."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from studies.open_world_second import arms, instruments, kinds, motions
from studies.open_world_second.outside import Outside
from studies.open_world_second.survey import survey
from studies.open_world_second.usual import slides, with_background
from tests.truth import ArmTruth, Motion

if TYPE_CHECKING:
    from studies.open_world.sensors import Sensors  # pyright: ignore[reportMissingImports]


class SecondWorld:
    """Draws everything that a trial needs; the same seeds give the same."""

    name = "second"
    OUTSIDE: tuple[str, ...] = kinds.NAMES

    def arm(self, seed: int) -> ArmTruth:
        """An arm as it truly is, with its background."""
        return with_background(arms.draw(seed), seed)

    def motion(self, arm: ArmTruth, seed: int, duration: float) -> Motion:
        """A motion of ``duration`` [s] inside the arm's limits, at rest at both ends; its ``kind`` is a word."""
        return motions.draw(arm, seed, duration)

    def sensors(self, seed: int, arm: ArmTruth | None = None) -> Sensors:
        """Instruments that fit an arm, without one the arm of the same seed."""
        from studies.open_world.sensors import Sensors  # pyright: ignore[reportMissingImports]

        carrier = arms.draw(seed) if arm is None else arm
        return Sensors(**instruments.draw(seed, survey(carrier).load, slides(carrier)))

    def conditions(self, seed: int) -> float:
        """How much warmer [K] a recording is than usual: mostly a little, at times as after hours of work."""
        rng = np.random.default_rng([seed, 451])
        return float(min(rng.exponential(2.0), 10.0)) if rng.random() < 0.6 else 0.0

    def outside(self, name: str, arm: ArmTruth, rng: np.random.Generator) -> Outside:
        """A cause of a kind in ``OUTSIDE``, drawn for an arm."""
        return kinds.draw(name, arm, rng)
