"""Designing a motion that tells two rival effects apart, and how large they must be for that."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import build_regressor
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.excitation.criterion.rivals import Rivals, arm_of, rivals_of, task_of_rivals
from physident.excitation.design import Design, Limits, check_counts, described, stated
from physident.excitation.limits.workspace import CLEARANCE
from physident.excitation.motion.motion import Motion
from physident.excitation.motion.trajectory import random_trajectory
from physident.excitation.search.search import GENERATIONS, STARTS, search
from physident.excitation.task import task_of
from physident.identifiability.projection import Baseline
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
EVIDENCE = 12.0  # what beats the luckiest of all candidates in noise: the surrogates' 98th percentile is near it
RATE = 125.0  # Hz, of the recording that is foreseen
USUAL_MOTIONS = 5  # random ones of the same length, for comparison


@dataclass(frozen=True)
class Detectable:
    """The least ``magnitude`` [unit] of an effect's parameter on a joint that shows beside its ``rival``, at the
    ``shape`` it would have, and what random motions of the same length need, their median (``usual``); infinite where it never shows."""

    effect: str
    rival: str
    joint: int
    parameter: str
    unit: str
    shape: tuple[float, ...]
    magnitude: float
    usual: float


@dataclass(frozen=True, eq=False)
class Discrimination:
    """A ``design`` that tells effects ``a`` and ``b`` apart, and the magnitudes that it can show, under torque noise of
    ``noise`` (n,) [N m|N] of which ``worth`` (n,) [1/s] samples a second are independent. The model is ``held`` where it
    would take up a rival whole, as on recordings new to it; else it is refitted."""

    a: str
    b: str
    held: bool
    design: Design
    detectable: tuple[Detectable, ...]
    noise: tuple[float, ...]
    worth: tuple[float, ...]

    def as_dict(self) -> dict[str, Any]:
        """The design and what it can show, as JSON can hold it."""
        rows = [
            {key: None if value == float("inf") else value for key, value in asdict(one).items()}
            for one in self.detectable
        ]
        own = {
            "effects": [self.a, self.b],
            "model_held": self.held,
            "noise": list(self.noise),
            "worth_per_second": list(self.worth),
        }
        return self.design.as_dict() | own | {"detectable": rows}

    def __repr__(self) -> str:
        from physident.excitation.design_text import discrimination_text

        return discrimination_text(self)


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
    """The motion on which two rival effects can be told apart, on one ``joint`` (from 1) or on all where both can be.

    It makes large what neither the model without the two, refitted, nor the rival at any shape can imitate of an
    effect's columns, for both effects alike. A change of a link shows only beside a model that is held, and is judged so.
    ``noise`` [N m|N] is the RMS of torque noise after the filter; an ``Estimate`` has its own. The other arguments are those
    of ``design_trajectory``. Raises InputError for effects, joints or settings that cannot be used, NotSolvedError where no
    motion within the limits was found.
    """
    arm = source.model if isinstance(source, Estimate) else arm_of(source)
    rivals = rivals_of(arm, effect_a, effect_b, joint)
    sigma, worth, filter = _noise(source, arm, noise)
    check_counts(periods=periods, starts=starts, generations=generations)
    general = task_of(source if isinstance(source, Estimate) else arm)
    task, criterion = task_of_rivals(rivals, replace(general, weights=1 / sigma))
    began = time.perf_counter(), time.process_time()
    problem = stated(task, limits, harmonics, base_frequency, table, clearance, meshes, criterion, arm)
    found = search(problem, seed, starts, generations, progress)
    design = described(general, problem, found, limits, periods, seed, generations, began)
    usual = [
        random_trajectory(arm.robot, s, harmonics, base_frequency, design.trajectory.duration)
        for s in range(USUAL_MOTIONS)
    ]
    shown = least_magnitudes(arm, rivals, design.trajectory, sigma, worth, filter)
    others = [least_magnitudes(arm, rivals, motion, sigma, worth, filter) for motion in usual]
    medians = np.median([[one.magnitude for one in other] for other in others], axis=0)
    detectable = tuple(replace(one, usual=float(m)) for one, m in zip(shown, medians, strict=True))
    return Discrimination(
        effect_a, effect_b, rivals.held, design, detectable, tuple(map(float, sigma)), tuple(map(float, worth))
    )


def least_magnitudes(
    model: Model, rivals: Rivals, motion: Motion, sigma: Array, worth: Array, filter: Filter
) -> list[Detectable]:
    """The least magnitude of each rival's parameters that shows beside the other along a motion.

    Left-out evidence is sum_j N_j log(before_j / after_j) over joints with N_j independent samples, as a diagnosis counts
    it; a magnitude m adds m^2 times the energy of the column outside baseline and rival, in units of the noise ``sigma`` (n,).
    """
    signals, n = _recorded(model, motion, filter), model.robot.n
    result = []
    for joint in rivals.joints:
        for name, other in ((rivals.a, rivals.b), (rivals.b, rivals.a)):
            beside = [*rivals.refitted, *rivals.on(other, joint)]
            whole = build_regressor(model.robot, beside, [signals], filter, model=model)
            memory = np.maximum(whole.kept_rate / worth, 1.0)
            baseline = Baseline.of(whole, 1 / (sigma * np.sqrt(memory)))
            samples = len(whole.time) * float(np.mean(1 / memory)) * n
            for option in rivals.on(name, joint):
                judged = baseline.project(build_regressor(model.robot, [option], [signals], filter, model=model))
                shape = tuple(float(v[0]) for s in option.shapes if (v := getattr(option, s.field)) is not None)
                for k, column in enumerate(option.columns(model.robot)):
                    inner, outside = float(judged.gram[k, k]), float(judged.outside_gram[k, k])
                    size = _needed(outside, samples) if outside > 1e-9 * inner > 0 else float("inf")
                    result.append(Detectable(name, other, joint, column.name, column.unit, shape, size, float("nan")))
    return result


def _needed(outside: float, samples: float) -> float:
    """The magnitude at which N log(1 + m^2 outside / N) reaches the evidence that is asked for."""
    return float(np.sqrt(samples * np.expm1(EVIDENCE / samples) / outside))


def _recorded(model: Model, motion: Motion, filter: Filter) -> Signals:
    """The signals of a perfect recording of a motion."""
    time, q, v, a = motion.sample(RATE)
    warmth = np.full_like(q, 25.0)
    plan = Signals(time, q, v, a, None, warmth, rate=RATE, cutoff=filter.cutoff, source="a planned motion")
    return replace(model.refer(plan), torque=model.torque(plan))


def _noise(source: Robot | Model | Estimate, arm: Model, noise: float | None) -> tuple[Array, Array, Filter]:
    """The noise after the filter (n,), how many samples a second are independent (n,), and the filter."""
    n = arm.robot.n
    if noise is not None and not (np.isfinite(noise) and noise > 0):
        raise InputError(f"noise is {noise}, expected a positive torque [N m], the RMS after the filter")
    if isinstance(source, Estimate):
        used = sum(one.used for one in source.sources)
        sigma = np.full(n, noise) if noise is not None else np.maximum(source.sigma, 1e-9 * source.sigma.max())
        return sigma, np.maximum(source.effective_samples / used, 1e-3), source.filter
    if noise is None:
        raise InputError(
            "how much torque noise? expected noise [N m] (--noise), or a model identified from recordings (--model)"
        )
    filter = Filter()
    return np.full(n, noise), np.full(n, 2 * filter.cutoff), filter
