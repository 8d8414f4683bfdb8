"""By how much the friction and the offsets of a healthy arm differ by themselves.

Friction changes by some per cent from day to day, and so do the zeros of sensors: by how much, the recordings say that the model was fitted
to, of which each is held against the others. A fault that is smaller than that cannot be told from a day.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.as_others_show import dense
from physident.diagnosis.grading.control import UNUSUAL, noise_of, rows_of_model
from physident.diagnosis.grading.scatter import Scatter, scatter_between
from physident.dynamics.friction_parameters import friction_values
from physident.dynamics.model import Model
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.signals import Filter, Signals

Array = NDArray[np.float64]
FEWEST = 3  # recordings: two say that they differ, and not by how much recordings usually do
LARGEST = 0.1  # of the friction: a larger change is worth a look, however far a few recordings, and what the model lacks, are apart


@dataclass(frozen=True, kw_only=True)
class UsualFriction:
    """By which share of its friction a ``joint`` of a healthy arm differs at most on a new day from some recordings before, and the whole
    ``arm``, all joints of which differ alike: one of twenty healthy arms differs by more on any joint; at most a tenth. ``offset`` is the most of
    a joint's torque offset, as a share of the RMS of its friction. ``spread`` and ``offset_spread`` are standard deviations of a joint's
    shares, with so many degrees of ``freedom``. So many ``recordings`` tell."""

    joint: float
    arm: float
    offset: float
    spread: float
    offset_spread: float
    freedom: int
    recordings: int

    @property
    def parts(self) -> int:
        """How many parts of a joint's friction differ, each by its own measure: dry friction and the other one, or, as far as so few recordings
        tell, all of it alike."""
        return 2 if self.recordings >= FEWEST else 1

    @staticmethod
    def unknown(recordings: int) -> UsualFriction:
        """What so few ``recordings`` say: that more than a tenth is not usual, as of any healthy arm, and no offset."""
        return UsualFriction(
            joint=LARGEST, arm=LARGEST, offset=0.0, spread=0.0, offset_spread=0.0, freedom=1, recordings=recordings
        )

    @staticmethod
    def of(model: Model, control: Sequence[Signals], filter: Filter, old: int) -> UsualFriction:
        """What the ``control`` says of a new day beside the mean of ``old`` recordings before.

        However many recordings are new, they count as one: those of one day have its friction in common.
        """
        from scipy.stats import t

        regressor, weights = rows_of_model(model, control, filter)
        n, values = model.robot.n, np.sum(friction_values(model), axis=0)
        common = list(find_base_parameters(model.robot, model.effects).independent)
        columns, torque, friction, constant = [], [], [], []
        for j in range(n):
            every, y = dense(regressor, j), regressor.torque[:, j]
            sigma = noise_of(every[:, common], y)
            columns.append(every[:, common] / sigma)
            torque.append(y / sigma)
            friction.append(every @ values / sigma)
            constant.append(as_large(weights[:, j], friction[j]))

        def scatter(effect: Sequence[Array], joints: Collection[int]) -> Scatter:
            some = [one if j in joints else np.zeros_like(one) for j, one in enumerate(effect)]
            return scatter_between([regressor], regressor.segment, columns, torque, some)

        days = float(np.sqrt(1 / old + 1))

        def of_joints(effect: Sequence[Array]) -> tuple[float, float, int]:
            """The most, the standard deviation, and its degrees of freedom, of a joint's share."""
            seen = [one for one in (scatter(effect, [j]) for j in range(n)) if one.count > 1]
            freedom = max(sum(one.count - 1 for one in seen), 1)
            spread = days * np.sqrt(sum(one.variance * (one.count - 1) for one in seen) / freedom)
            return min(LARGEST, float(t.ppf(1 - UNUSUAL / (2 * n), freedom) * spread)), float(spread), freedom

        whole = scatter(friction, range(n))
        arm = t.ppf(1 - UNUSUAL / 2, max(whole.count - 1, 1)) * np.sqrt(whole.variance) * days
        (joint, spread, freedom), (offset, offset_spread, _) = of_joints(friction), of_joints(constant)
        return UsualFriction(
            joint=joint,
            arm=min(LARGEST, float(arm)),
            offset=offset,
            spread=spread,
            offset_spread=offset_spread,
            freedom=freedom,
            recordings=len(control),
        )


def as_large(weights: Array, friction: Array) -> Array:
    """A constant in weighted rows (M,) that is as large as the RMS of friction there."""
    rows = float(weights @ weights)
    return weights * (np.linalg.norm(friction) / np.sqrt(rows) if rows else 0.0)
