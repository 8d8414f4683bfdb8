"""Causes outside the catalogue that a plant must do by itself: play, loose and lost parts, and a soft pedestal."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from studies.open_world_second.bodies import rigid
from studies.open_world_second.outside import MOST, Outside, Structural
from studies.open_world_second.survey import Survey
from studies.open_world_second.tool_causes import tool_at
from tests.truth import ArmTruth

Array = NDArray[np.float64]
WEIGHT = 9.81  # N/kg
PLAY = 0.04  # rad at relative size 1
LEAN = 0.08  # rad of the pedestal at relative size 1, under the arm's usual moment


def loose_gear(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Outside:
    """A worn gear with play at one revolute joint."""
    model, _ = rigid(arm.urdf)
    turning = [j for j in range(arm.joints) if "R" in model.joints[j + 1].shortname()]
    j = int(rng.choice(turning)) + 1
    return Outside("loose_gear", (j,), "other", Structural("backlash", (j,), PLAY), MOST)


def hanging_part(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Outside:
    """Something that hangs from the tool on a string."""
    unit, joints = _weight(arm, usual)
    shape = {"length": float(rng.uniform(0.12, 0.45))}
    return Outside("hanging_part", joints, "other", Structural("swinging_load", (), unit, shape), MOST)


def lost_part(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Outside:
    """A part that falls out of the gripper on the way."""
    unit, joints = _weight(arm, usual)
    model, _ = rigid(arm.urdf)
    mount = np.array(model.frames[model.getFrameId(arm.tool)].placement.translation)
    com = mount + rng.uniform(-0.02, 0.02, 3)
    shape = {"com": tuple(com.tolist()), "time": float(rng.uniform(4, 9))}
    return Outside("lost_part", joints, "time", Structural("dropped_load", (), unit, shape), MOST)


def soft_pedestal(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Outside:
    """A pedestal of thin sheet that leans under the arm."""
    model, data = rigid(arm.urdf, arm.links)
    poses = np.concatenate([part.q[::20] for part in usual.stretches])
    centres = np.array([pin.centerOfMass(model, data, q).copy() for q in poses])
    moment = arm.links[:, 0].sum() * WEIGHT * np.sqrt(np.mean(centres[:, :2] ** 2) + np.mean(centres[:, 2] ** 2) / 4)
    unit = LEAN / float(moment) * rng.uniform(0.7, 1.3)
    joints = tuple(range(1, arm.joints + 1))
    return Outside("soft_pedestal", joints, "other", Structural("flexible_base", (), unit), MOST)


def _weight(arm: ArmTruth, usual: Survey) -> tuple[float, tuple[int, ...]]:
    """Mass [kg] at the tool whose weight is the usual torque of the joint that feels it most, and the joints that do."""
    poses = np.concatenate([part.q[::10] for part in usual.stretches])
    torque = np.array([tool_at(arm.urdf, arm.tool, q)[1][2] * WEIGHT for q in poses])
    share = np.sqrt(np.mean(torque**2, axis=0)) / usual.load
    return 1 / float(share.max()), tuple(int(j) + 1 for j in np.flatnonzero(share > share.max() / 3))


STRUCTURES: dict[str, Callable[[ArmTruth, Survey, np.random.Generator], Outside]] = {
    "loose_gear": loose_gear,
    "hanging_part": hanging_part,
    "lost_part": lost_part,
    "soft_pedestal": soft_pedestal,
}
