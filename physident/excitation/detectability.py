"""The smallest magnitude of an effect that a recording of a motion shows beside a rival effect."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import build_regressor
from physident.excitation.motion.motion import Motion
from physident.excitation.rival_effects import Rivals
from physident.identifiability.projection import Baseline
from physident.recordings.signals import Filter, Signals

Array = NDArray[np.float64]
EVIDENCE = 12.0  # the threshold: near the 98th percentile of the best candidate's evidence on surrogates of a residual
RATE = 125.0  # Hz, of the recording that is assumed
TEMPERATURE = 25.0  # degC, of that recording


@dataclass(frozen=True, kw_only=True)
class Noise:
    """Torque noise after the ``filter``: RMS ``sigma`` (n,) [N m|N], and independent samples per second ``worth`` (n,)."""

    sigma: Array
    worth: Array
    filter: Filter


@dataclass(frozen=True, kw_only=True)
class Detectable:
    """The smallest ``magnitude`` [``unit``] of an effect's ``parameter`` on a joint that shows beside its ``rival``.

    ``shape`` are the effect's shape parameters. ``usual`` is the median magnitude that random motions of the same length
    need. Both are infinite where the effect never shows. ``beyond`` [N m|N] is the effect's largest torque at that magnitude where
    the joint's drive has less, and None where it has as much.
    """

    effect: str
    rival: str
    joint: int
    parameter: str
    unit: str
    shape: tuple[float, ...]
    magnitude: float
    usual: float = float("nan")
    beyond: float | None = None


def detectable_magnitudes(model: Model, rivals: Rivals, motion: Motion, noise: Noise) -> list[Detectable]:
    """The smallest magnitude of each rival's parameters that shows beside the other rival along a motion.

    The evidence of a diagnosis is sum_j N_j log(before_j / after_j) over joints with N_j independent samples. A magnitude m
    adds m^2 times the energy of the column outside baseline and rival, in units of the noise.
    """
    signals, n, filter = _simulated_signals(model, motion, noise.filter), model.robot.n, noise.filter
    result = []
    for joint in rivals.joints:
        for name, rival in ((rivals.a, rivals.b), (rivals.b, rivals.a)):
            beside = [*rivals.refitted, *rivals.on(rival, joint)]
            regressor = build_regressor(model.robot, beside, [signals], filter, model=model)
            memory = np.maximum(regressor.kept_rate / noise.worth, 1.0)
            baseline = Baseline.of(regressor, 1 / (noise.sigma * np.sqrt(memory)))
            samples = len(regressor.time) * float(np.mean(1 / memory)) * n
            for variant in rivals.on(name, joint):
                alone = build_regressor(model.robot, [variant], [signals], filter, model=model)
                projection, largest = baseline.project(alone), np.abs(alone.Y[:, joint - 1]).max(axis=0)
                shape = tuple(
                    float(v[0]) for s in variant.shape_parameters if (v := getattr(variant, s.field)) is not None
                )
                for k, column in enumerate(variant.columns(model.robot)):
                    inner, outside = float(projection.gram[k, k]), float(projection.outside_gram[k, k])
                    shows = outside > 1e-9 * inner > 0
                    magnitude = _magnitude(outside, samples) if shows else float("inf")
                    torque = magnitude * float(largest[k]) if shows else 0.0
                    result.append(
                        Detectable(
                            effect=name, rival=rival, joint=joint, parameter=column.name, unit=column.unit, shape=shape,
                            magnitude=magnitude, beyond=torque if torque > model.robot.torque_limit[joint - 1] else None,
                        )
                    )  # fmt: skip
    return result


def _magnitude(outside: float, samples: float) -> float:
    """The magnitude m at which N log(1 + m^2 outside / N) reaches the threshold of the evidence."""
    return float(np.sqrt(samples * np.expm1(EVIDENCE / samples) / outside))


def _simulated_signals(model: Model, motion: Motion, filter: Filter) -> Signals:
    """The signals of a recording of a motion without noise."""
    time, q, v, a = motion.sample(RATE)
    temperature = np.full_like(q, TEMPERATURE)
    plan = Signals(time, q, v, a, None, temperature, rate=RATE, cutoff=filter.cutoff, source="a planned motion")
    return replace(model.refer(plan), torque=model.torque(plan))
