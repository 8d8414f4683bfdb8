"""A cause from outside the catalogue on one arm: where it acts, and how it is made in any size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from studies.open_world_second.survey import Survey
from tests.truth import ArmTruth, Disturbance, HiddenEffect

Array = NDArray[np.float64]
Variable = Literal["position", "velocity", "load", "time", "other"]
Made = tuple[tuple[HiddenEffect, ...], tuple[Disturbance, ...]]
Drawn = tuple[Variable, Any, float]  # its disturbance at size 0, and the largest size in the disturbance's own unit
Draw = Callable[[ArmTruth, Survey, np.random.Generator], Drawn]
MOST = 0.6  # of the usual torque of a joint: more than that nobody overlooks
MEASURED = 0.2  # the share at which a cause is measured
ROUNDS = 5  # sizes tried for a share that does not grow in proportion to size


@dataclass(frozen=True)
class Outside:
    """A cause ``kind`` at ``joints`` (from 1) that goes with ``variable``; ``make`` takes a size up to ``most``.

    Size 0.2 adds about 20 % of its usual root mean square torque to the joint that feels the cause most.
    """

    kind: str
    joints: tuple[int, ...]
    variable: Variable
    make: Callable[[float], Made]
    most: float


@dataclass(frozen=True, eq=False)
class Scaled:
    """Makes a disturbance whose field ``size`` is ``unit`` at relative size 1."""

    disturbance: Any
    unit: float

    def __call__(self, size: float) -> Made:
        return (), (replace(self.disturbance, size=self.unit * size),)


@dataclass(frozen=True, eq=False)
class Structural:
    """Makes an effect that a plant does by itself, of ``unit`` at relative size 1."""

    effect: str
    joints: tuple[int, ...]
    unit: float
    shape: dict[str, Any] = field(default_factory=dict)

    def __call__(self, size: float) -> Made:
        return (HiddenEffect(effect=self.effect, joints=self.joints, size=self.unit * size, shape=self.shape),), ()


def measured(kind: str, variable: Variable, disturbance: Any, ceiling: float, survey: Survey) -> Outside:
    """The cause with sizes relative to what it adds on the survey; ``ceiling`` bounds the disturbance's own ``size``."""
    size = ceiling / 10
    share = survey.share(replace(disturbance, size=size))
    for _ in range(ROUNDS):
        if abs(share.max() / MEASURED - 1) < 0.02:
            break
        size = min(size * MEASURED / max(float(share.max()), 1e-4), ceiling)
        share = survey.share(replace(disturbance, size=size))
    unit = size / float(share.max())
    joints = tuple(int(j) + 1 for j in np.flatnonzero(share > share.max() / 3))
    return Outside(kind, joints, variable, Scaled(disturbance, unit), min(MOST, ceiling / unit))


def any_joint(arm: ArmTruth, rng: np.random.Generator) -> int:
    """A joint of the arm, from 0."""
    return int(rng.integers(arm.joints))
