"""Identification as physident does it: the whole arm at once, with friction, rotors and offsets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.dynamics.regressor import build_regressor
from physident.estimation.regressor_fit import estimate_from
from studies.thesis.published import COULOMB, OFFSET
from studies.thesis.reference import FRICTION, Run
from studies.thesis.scores import FILTER

Array = NDArray[np.float64]
NO_WIDTH = 1e-8  # rad/s: the references' sign has no width, and their velocities no noise that would ask for one
PHYSICAL = pid.Physical(resamples=0)  # the values are compared here; intervals are those of weighted least squares


def effects(width: float = NO_WIDTH) -> tuple[pid.Effect, ...]:
    """The five default effects, friction with a sign of some width [rad/s], as sharp as the references' by default."""
    sharp = pid.CATALOGUE["coulomb_friction"](smoothing=width)
    return pid.make_effects(["rigid_body", "rotor_inertia", "viscous_friction", sharp, "torque_offset"])


def regressor(robot: pid.Robot, run: Run) -> pid.Regressor:
    """The regressor of a run, from exact derivatives, both sides filtered."""
    return build_regressor(robot, effects(), [run.signals()], FILTER, moving_only=False)


def identify(robot: pid.Robot, run: Run, method: str | pid.Physical) -> pid.Estimate:
    """The estimate of one run from exact derivatives."""
    return estimate_from(robot, effects(), regressor(robot, run), [], method, FILTER)


def truth(robot: pid.Robot, model: str) -> Array:
    """All parameters of a reference model in the order of ``effects``: links, no rotors, no viscous friction, Table 2.5."""
    acts = float(FRICTION[model])
    return np.concatenate([robot.nominal, np.zeros(2 * robot.n), acts * COULOMB, acts * OFFSET])


def true_torque(robot: pid.Robot, model: str, run: Run, width: float) -> Array:
    """Torque (N, 6) [N m] of the true parameters with a sign of some width [rad/s]."""
    return pid.Model(robot, effects(width), truth(robot, model)).torque(run.signals())


@dataclass(frozen=True, eq=False)
class Found:
    """An estimate, or why there is none."""

    estimate: pid.Estimate | None
    why: str = ""


def attempt(robot: pid.Robot, run: Run, method: str | pid.Physical) -> Found:
    """``identify``, with a refusal kept as its sentence."""
    try:
        return Found(identify(robot, run, method))
    except pid.NotSolvedError as error:
        return Found(None, str(error))
