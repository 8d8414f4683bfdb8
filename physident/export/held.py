"""What a file format holds of a model, and how much worse the torque is that it holds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.classification import Detection, units_in_words
from physident.effects.effect import Effect
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.excitation.motion.trajectory import random_trajectory
from physident.export.joint_friction import Line, added, nearest_lines
from physident.recordings.recording import Recording
from physident.recordings.signals import Signals
from physident.robots.kinematic_tree import Joint
from physident.robots.robot import Robot
from physident.validation.scores import compared

Array = NDArray[np.float64]
TOLERATED = 1.1  # times the model's own error: more than its rounding to the terms of the format should cost
PRINTED_VALUES = 12  # of an effect that a format cannot express
SAMPLED = 20.0, 50.0  # s, Hz: a motion that stands for the training recordings where they are not at hand


@dataclass(frozen=True, eq=False)
class Held:
    """The part of a model that a format holds.

    ``model`` has the effects that it holds, folded where they remember, and those of the torque measurement, which are no
    part of an arm. ``folded`` and ``lost`` have one line for each effect that was changed or left out, ``measured`` one
    for each effect of the measurement; ``left_out`` are the effects of the plant that it cannot hold. Where a format has
    damping and dry friction that are not negative only, it holds those nearest to a joint's friction, and ``left_out`` has the rest.
    """

    model: Model
    folded: tuple[str, ...]
    lost: tuple[str, ...]
    measured: tuple[str, ...]
    left_out: tuple[tuple[Effect, Array], ...]


def held_by(model: Model, holds: Callable[[Effect, Array], bool]) -> Held:
    """The part of a model that a format holds, where ``holds`` decides on one effect and its parameters (k,)."""
    kept: list[tuple[Effect, Array]] = []
    left_out: list[tuple[Effect, Array]] = []
    folded, lost, measured = [], [], []
    for effect, theta in model.effect_parameters():
        simpler, values = effect.folded(model.robot, theta)
        if effect.acts_on == "measurement":
            kept.append((effect, theta))
            measured.append(described(model.robot, effect, theta))
        elif holds(simpler, values):
            kept.append((simpler, values))
            if simpler is not effect:
                joints = [str(j + 1) for j in effect.active(model.robot)]
                folded.append(
                    f"{effect.name} on joint{'s' if len(joints) > 1 else ''} {', '.join(joints)} written as {described(model.robot, simpler, values)}"
                )
        else:
            left_out.append((effect, theta))
            lost.append(described(model.robot, effect, theta))
    lines = nearest_lines(model.robot, kept, left_out)
    folded += [_written(model.robot.joints[line.joint], line) for line in lines]
    kept += added(lines, 1.0)
    left_out += added(lines, -1.0)
    parameters = np.concatenate([np.zeros(0), *(values for _, values in kept)])
    part = Model(model.robot, tuple(effect for effect, _ in kept), parameters)
    return Held(part, tuple(folded), tuple(lost), tuple(measured), tuple(left_out))


def of_one_instant(model: Model) -> tuple[Model, tuple[str, ...]]:
    """The model without its delays of the torque measurement, which no function of one instant has, and a line for each."""
    kept: list[tuple[Effect, Array]] = []
    late: list[str] = []
    for effect, theta in model.effect_parameters():
        if effect.acts_on == "measurement" and not effect.pointwise:
            late.append(described(model.robot, effect, theta))
        else:
            kept.append((effect, theta))
    parameters = np.concatenate([np.zeros(0), *(theta for _, theta in kept)])
    return Model(model.robot, tuple(effect for effect, _ in kept), parameters), tuple(late)


def _written(joint: Joint, line: Line) -> str:
    """What was written for the friction of a joint, in one line."""
    damping, dry = f"{line.damping:.4g} {joint.unit('N m s/rad')}", f"{line.dry:.4g} {joint.unit('N m')}"
    return f"friction of joint {line.joint + 1} ({joint.name}) written as the nearest damping {damping} and dry friction {dry}"


def described(robot: Robot, effect: Effect, theta: Array) -> str:
    """An effect with what its parameters (k,) mean, or with its unit and the first of them, in one line."""
    if words := effect.in_words(robot, theta):
        return f"{effect.name}: {words.removesuffix('.')}"
    more = ", ..." if len(theta) > PRINTED_VALUES else ""
    return f"{effect.name} [{units_in_words(effect.columns(robot))}] {', '.join(f'{value:.4g}' for value in theta[:PRINTED_VALUES])}{more}"


def loss_of_torque(estimate: Estimate, held: Model, recordings: Sequence[Recording] = ()) -> str | None:
    """One sentence on the joints whose torque errs more than a tenth above the model's own error in an export; or None.

    ``recordings`` are the training recordings. Without them, the difference of the two torques along a random motion
    inside the robot's limits is added to the error of the fit.
    """
    lasting = [(e, theta) for e, theta in estimate.model.effect_parameters() if e.detection is not Detection.BY_TIME]
    whole = Model(estimate.model.robot, tuple(e for e, _ in lasting), np.concatenate([theta for _, theta in lasting]))
    before = replace(estimate, model=whole)
    if recordings:
        gain = compared(before, replace(estimate, model=held), recordings, include_fitted=True)
        own, exported, where = gain.before.rms, gain.after.rms, "on the training recordings"
    else:
        own, exported, where = *_along_random_motion(before, held), "along a random motion inside the limits"
    worse = [
        f"joint {j} {after:.3g} instead of {error:.3g} {unit}"
        for j, (error, after, unit) in enumerate(zip(own, exported, whole.robot.torque_units, strict=True), 1)
        if after > TOLERATED * error
    ]
    if not worse:
        return None
    return f"the torque of the exported model errs more {where} than the model's own: {', '.join(worse)} (RMS)"


def _along_random_motion(estimate: Estimate, held: Model) -> tuple[Array, Array]:
    duration, rate = SAMPLED
    motion = random_trajectory(estimate.model.robot, seed=0, duration=duration)
    time, q, v, a = motion.sample(rate)
    signals = Signals(time, q, v, a, rate=rate, cutoff=estimate.filter.cutoff)
    try:
        difference = estimate.filter.apply((held.torque(signals) - estimate.model.torque(signals)).T, rate).T
    except InputError as error:
        raise InputError(f"the exported torque cannot be compared along a random motion: {error}") from None
    return estimate.sigma, np.hypot(estimate.sigma, np.sqrt((difference**2).mean(axis=0)))
