"""A nuisance column: the difference between sgn(v) of the measured velocity and of the differentiated position.

Near reversals the sign of a noisy velocity is blurred. The resulting residual is not a property of the arm, but effects with
a memory average the noise and would be mistaken for its cause.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from physident.effects.effect import Array, Effect
from physident.effects.friction import smooth_sign
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

WINDOW = 9  # samples of the local fit of fourth order: a fifth of the noise of plain differences


@dataclass(frozen=True)
class SignByPosition(Effect):
    """What sgn v changes by when the velocity is the derivative of position, one column a joint; never part of a model.

    A difference, so that the Coulomb friction beside it keeps its value.
    """

    name: ClassVar[str] = "sign_by_position"
    unit: ClassVar[str] = "N m"
    pointwise: ClassVar[bool] = False

    def values(self, robot: Robot, signals: Signals) -> Array:
        from scipy.signal import savgol_filter

        q = signals.q.T[self.active(robot)]
        window = min(WINDOW, (q.shape[1] - 1) // 2 * 2 + 1)
        v = savgol_filter(q, window, min(4, window - 1), deriv=1, delta=1 / signals.rate, axis=1)
        return smooth_sign(np.asarray(v)) - smooth_sign(signals.v.T[self.active(robot)])
