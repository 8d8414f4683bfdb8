"""The background of one arm: which unmodelled physics it has, and how much of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from studies.open_world_second import background as b
from studies.open_world_second.survey import Survey, survey
from tests.truth import ArmTruth

Array = NDArray[np.float64]
SHARE = (0.02, 0.10)  # of a joint's usual torque, all disturbances together
Make = Callable[[ArmTruth, Survey, np.random.Generator], b.Background]


def with_background(arm: ArmTruth, seed: int) -> ArmTruth:
    """The arm with three to five disturbances that make 2 to 10 % of each joint's torque on ordinary motions."""
    rng = np.random.default_rng([seed, 431])
    measured = survey(arm)
    names = rng.permutation(list(KINDS))[: int(rng.integers(3, 6))]
    parts = [KINDS[name](arm, measured, rng) for name in names]
    weight = np.sqrt(rng.dirichlet(np.full(len(parts), 1.5), arm.joints)).T
    wanted = rng.uniform(*SHARE, arm.joints)
    parts = [
        replace(part, size=part.size * wanted * w / np.maximum(measured.share(part), 1e-9))
        for part, w in zip(parts, weight, strict=True)
    ]
    total = measured.share(*parts)  # not quite what was wanted: the parts are not independent of each other
    return replace(arm, background=tuple(replace(part, size=part.size * wanted / total) for part in parts))


def _dress_pack(arm: ArmTruth, measured: Survey, rng: np.random.Generator) -> b.Background:
    n = arm.joints
    spread = _spread(arm, measured)
    rest = np.array([measured.quantile(j, rng.uniform(0.2, 0.8)) for j in range(n)])
    sliding = slides(arm)
    shared = rng.uniform(0.1, 0.6, n) * ~sliding * ~np.append(sliding[1:], True)
    return b.DressPack(size=measured.load, rest=rest, slack=spread * rng.uniform(0.2, 0.5, n), shared=shared)


def _cogging(arm: ArmTruth, measured: Survey, rng: np.random.Generator) -> b.Background:
    n = arm.joints
    return b.WanderingCogging(
        size=measured.load,
        order=rng.uniform(8, 60, n) / _spread(arm, measured),
        phase=rng.uniform(0, 2 * np.pi, n),
        depth=rng.uniform(0.5, 3.0, n),
        period=float(rng.uniform(6, 25)),
    )


def _grease(arm: ArmTruth, measured: Survey, rng: np.random.Generator) -> b.Background:
    n = arm.joints
    crest = arm.top_speed * rng.uniform(0.08, 0.35, n)
    return b.ThickeningGrease(size=measured.load, crest=crest, thinning=rng.uniform(0.7, 1.3, n))


def _preload(arm: ArmTruth, measured: Survey, rng: np.random.Generator) -> b.Background:
    n = arm.joints
    turns = rng.integers(1, 4, n).astype(np.float64) * np.where(slides(arm), 2 * np.pi / _spread(arm, measured), 1.0)
    return b.UnevenPreload(
        size=measured.load, phase=rng.uniform(0, 2 * np.pi, n), speed=0.3 * arm.top_speed, per_turn=turns
    )


def _crosstalk(arm: ArmTruth, measured: Survey, rng: np.random.Generator) -> b.Background:
    n = arm.joints
    mix = rng.normal(size=(n, n))
    np.fill_diagonal(mix, 0.0)
    return b.Crosstalk(size=measured.load, mix=mix, usual=measured.load)


def _zero(arm: ArmTruth, measured: Survey, rng: np.random.Generator) -> b.Background:
    shape = (3, arm.joints)
    period, phase = rng.uniform(8, 70, shape), rng.uniform(0, 2 * np.pi, shape)
    return b.WanderingZero(size=measured.load, period=period, phase=phase)


def _ringing(arm: ArmTruth, measured: Survey, rng: np.random.Generator) -> b.Background:
    frequency, damping = rng.uniform(4, 12), rng.uniform(0.03, 0.2)
    return b.RingingFrame(size=np.ones(arm.joints), frequency=float(frequency), damping=float(damping))


def _breathing(arm: ArmTruth, measured: Survey, rng: np.random.Generator) -> b.Background:
    n = arm.joints
    return b.Breathing(
        size=measured.load,
        period=float(rng.uniform(1.5, 6.0)),
        edge=float(rng.uniform(1.0, 4.0)),
        lever=rng.normal(size=n),
        turn=rng.uniform(0, 2 * np.pi, n),
    )


def _spread(arm: ArmTruth, measured: Survey) -> Array:
    return np.array([measured.spread(j) for j in range(arm.joints)])


def slides(arm: ArmTruth) -> NDArray[np.bool_]:
    """Which joints (n,) are prismatic, by their description."""
    kinds = [line for line in arm.urdf.splitlines() if 'type="revolute"' in line or 'type="prismatic"' in line]
    return np.array(["prismatic" in line for line in kinds])


KINDS: dict[str, Make] = {
    "dress_pack": _dress_pack,
    "cogging": _cogging,
    "grease": _grease,
    "preload": _preload,
    "crosstalk": _crosstalk,
    "zero": _zero,
    "ringing": _ringing,
    "breathing": _breathing,
}
