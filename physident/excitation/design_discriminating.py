"""Design the motion that separates two rival effects."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from physident.dynamics.model import Model
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.excitation.design import Limits
from physident.excitation.design_trajectory import Settings, solve_design
from physident.excitation.detectability import Noise, detectable_magnitudes
from physident.excitation.discrimination import Discrimination
from physident.excitation.limits.workspace import CLEARANCE
from physident.excitation.motion.trajectory import random_trajectory
from physident.excitation.rival_effects import rivals_of, task_of_rivals
from physident.excitation.search.search import GENERATIONS, STARTS
from physident.excitation.task import task_of
from physident.recordings.signals import Filter
from physident.robots.robot import Robot
from physident.threads import one_thread

LOUDEST = 1e9  # N m: no drive has as much torque
RANDOM_MOTIONS = 5  # of the same length, for comparison


@one_thread
def design_discriminating(
    source: Robot | Model | Estimate,
    effect_a: str,
    effect_b: str,
    joint: int | None = None,
    limits: Limits = "all",
    harmonics: int = 5,
    base_frequency: float = 0.1,
    periods: int = 2,
    seed: int = 0,
    noise: float | None = None,
    table: float | None = 0.0,
    clearance: float = CLEARANCE,
    meshes: str | Path | None = None,
    starts: int = STARTS,
    generations: int = GENERATIONS,
    progress: Callable[[float], None] = lambda _: None,
) -> Discrimination:
    """Design a motion on which two rival effects differ most, on one ``joint`` (from 1) or on all that both can act on.

    It maximises the part of each effect's columns that neither the model without the two, refitted, nor the rival at any
    shape can imitate, for both effects alike. A refitted rigid body contains any change of a link, so for ``payload`` and
    ``link_inertia`` the model is fixed. ``noise`` [N m|N] is the RMS of the torque noise after the filter; an ``Estimate``
    brings its own. The other arguments are those of ``design_trajectory``.

    Raises InputError for effects, joints or settings that cannot be used, and NotSolvedError where no motion within the
    limits was found.
    """
    arm = (
        source.model if isinstance(source, Estimate) else Model.nominal(source) if isinstance(source, Robot) else source
    )
    rivals = rivals_of(arm, effect_a, effect_b, joint)
    torque_noise = _noise(source, arm, noise)
    settings = Settings(
        limits=limits, harmonics=harmonics, base_frequency=base_frequency, periods=periods, seed=seed, table=table,
        clearance=clearance, meshes=meshes, starts=starts, generations=generations,
    )  # fmt: skip
    general = task_of(source if isinstance(source, Estimate) else arm)
    task, criterion = task_of_rivals(rivals, replace(general, weights=1 / torque_noise.sigma))
    design = solve_design(settings, task, general, criterion, arm, progress)
    detectable = detectable_magnitudes(arm, rivals, design.trajectory, torque_noise)
    duration = design.trajectory.duration
    random = [random_trajectory(arm.robot, k, harmonics, base_frequency, duration) for k in range(RANDOM_MOTIONS)]
    needed = [[one.magnitude for one in detectable_magnitudes(arm, rivals, m, torque_noise)] for m in random]
    medians = np.median(needed, axis=0)
    return Discrimination(
        a=effect_a,
        b=effect_b,
        model_fixed=rivals.model_fixed,
        design=design,
        detectable=tuple(replace(one, usual=float(m)) for one, m in zip(detectable, medians, strict=True)),
        noise=tuple(map(float, torque_noise.sigma)),
        worth=tuple(map(float, torque_noise.worth)),
    )


def _noise(source: Robot | Model | Estimate, arm: Model, noise: float | None) -> Noise:
    """The noise that was given, or that of the estimate's residual."""
    n = arm.robot.n
    if noise is not None and not 0 < noise < LOUDEST:
        raise InputError(
            f"noise is {noise}, expected a positive torque [N m] below {LOUDEST:g}, the RMS after the filter"
        )
    if isinstance(source, Estimate):
        used = sum(one.used for one in source.sources)
        sigma = np.full(n, noise) if noise is not None else np.maximum(source.sigma, 1e-9 * source.sigma.max())
        return Noise(sigma=sigma, worth=np.maximum(source.effective_samples / used, 1e-3), filter=source.filter)
    if noise is None:
        raise InputError(
            "how much torque noise? expected noise [N m] (--noise), or a model identified from recordings (--model)"
        )
    filter = Filter()
    return Noise(sigma=np.full(n, noise), worth=np.full(n, 2 * filter.cutoff), filter=filter)
