"""How strong an effect must be for an oracle, who knows its torque, to remove so much of the RMS on a held-out recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.dynamics.regressor import Regressor, build_regressor
from physident.effects.catalogue import DEFAULT_EFFECTS
from physident.effects.effect import Effect
from physident.estimation.estimate import as_estimate
from physident.estimation.identify import prepare_moving
from studies.blind_trials.arms import FILTER, Taken
from studies.blind_trials.cases import Hidden
from tests.plant import Arm, hide, torque_along
from tests.plant.motions import Motion

Array = NDArray[np.float64]
RATE = 125.0  # Hz


@dataclass(frozen=True, eq=False)
class Oracle:
    """Reduction (n,) [%] of RMS on the held-out recording with the hidden torque known, by joint; and the RMS (n,) left."""

    reduction: Array
    after: Array

    @property
    def joint(self) -> int:
        """Index of the joint that shows it most."""
        return int(np.argmax(self.reduction))

    @property
    def percent(self) -> float:
        """The reduction on that joint."""
        return float(self.reduction[self.joint])


def oracle(
    question: str, model: pid.Estimate | pid.Model, changed: Sequence[Taken], hidden: Sequence[Hidden]
) -> Oracle:
    """The oracle's gain on the last recording: the same models with the hidden torque taken away; to ask what is ``missing``
    they are fitted to the others. A contact, which no other recording predicts, is judged on the first."""
    held = changed[0] if any(h.effect == "contact" for h in hidden) else changed[-1]
    if question == "missing" and held is changed[-1]:
        robot = pid.load_robot("ur5")
        before = pid.identify(robot, [t.recording for t in changed[:-1]], filter=FILTER)
        after = pid.identify(robot, [t.without for t in changed[:-1]], filter=FILTER)
    else:
        before = after = as_estimate(model, FILTER)
    first = pid.validate(before, [held.recording], include_fitted=True).rms
    second = pid.validate(after, [held.without], include_fitted=True).rms
    return Oracle(100 * (1 - second / first), second)


def filtered(recordings: Sequence[pid.Recording], effects: Sequence[Effect] | None = None) -> Regressor:
    """Torque of recordings after the filter, and the columns of the ordinary model or of its ``effects``."""
    robot, effects = pid.load_robot("ur5"), effects or pid.make_effects(DEFAULT_EFFECTS)
    return build_regressor(robot, effects, prepare_moving(robot, recordings, FILTER), FILTER)


def pilot(hidden: Hidden, arm: Arm, plans: Sequence[Motion], question: str) -> Array:
    """RMS (n,) [N m] of the hidden effect's torque on the last planned motion after the filter, at its present magnitude;
    where the question is what is missing, of what a fit to the other motions leaves of it."""
    size, shape = hidden.doses()
    other = hide(arm, hidden.effect, hidden.joints, size, **shape)
    alone = [_difference(plan, other, arm) for plan in plans]
    test = filtered(alone[-1:])
    if question != "missing":
        return np.sqrt(np.mean(test.torque**2, axis=0))
    fitted = filtered(alone[:-1])
    left = np.empty(6)
    for j, (rows, own) in enumerate(zip(fitted.joints, test.joints, strict=True)):
        x = np.linalg.lstsq(rows.values, fitted.torque[:, j], rcond=1e-4)[0]
        left[j] = np.sqrt(np.mean((test.torque[:, j] - own.values @ x) ** 2))
    return left


def _difference(plan: Motion, other: Arm, arm: Arm) -> pid.Recording:
    """A recording along a plan that is followed exactly, with the torque by which two arms differ."""
    time = np.arange(0.0, plan.duration, 1 / RATE)
    q, v, a = plan.states(time)
    effort = torque_along(other, time, q, v, a) - torque_along(arm, time, q, v, a)
    return pid.Recording(time, q, effort, "torque", dq=v)


def scale(percent: float, size: Array, noise: Array) -> float:
    """The factor on an effect of RMS ``size`` (n,) that makes its removal worth ``percent`` on the joint that shows it most."""
    ratio = float(np.max(size / noise))
    wanted = float(np.sqrt(1 / (1 - percent / 100) ** 2 - 1))
    return wanted / max(ratio, 1e-300)
