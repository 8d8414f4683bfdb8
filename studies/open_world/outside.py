"""Causes outside of the catalogue: no effect of it is the right name for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from studies.open_world.outside_laws import (
    BackEmf,
    ChangingCrossTalk,
    CubicCable,
    DeadBand,
    GasSpring,
    Saturation,
    SensorLag,
    TightSpot,
)
from studies.open_world.scale import scale_of
from tests.truth import ArmTruth, Disturbance, HiddenEffect

Array = NDArray[np.float64]
Rng = np.random.Generator
Variable = Literal["position", "velocity", "load", "time", "other"]
Hidden = tuple[tuple[HiddenEffect, ...], tuple[Disturbance, ...]]


@dataclass(frozen=True, eq=False)
class Outside:
    """A cause outside of the catalogue: ``joints`` (from 1) where it acts, the ``variable`` that its torque depends on most,
    and ``make(size)``, which gives what a plant hides for a relative size up to ``most``."""

    kind: str
    joints: tuple[int, ...]
    variable: Variable
    make: Callable[[float], Hidden]
    most: float = 1.0


def outside(name: str, arm: ArmTruth, rng: Rng) -> Outside:
    """A cause somewhere on an arm, of random shape."""
    return MAKERS[name](arm, rng)


def _row(n: int, joint: int, value: float) -> Array:
    row = np.zeros(n)
    row[joint] = value
    return row


def _turning(arm: ArmTruth, rng: Rng) -> int:
    """Index of a joint that turns."""
    return int(rng.choice(np.flatnonzero(~scale_of(arm).prismatic)))


def _place(arm: ArmTruth, joint: int, rng: Rng) -> float:
    """A position [rad] in the middle part of a joint's range."""
    return float(arm.lower[joint] + rng.uniform(0.3, 0.7) * (arm.upper[joint] - arm.lower[joint]))


def _backlash(arm: ArmTruth, rng: Rng) -> Outside:
    j = _turning(arm, rng)
    return Outside("backlash", (j + 1,), "load", lambda s: ((_effect("backlash", (j + 1,), 0.04 * s),), ()))


def _gas_spring(arm: ArmTruth, rng: Rng) -> Outside:
    j, force = _turning(arm, rng), 3.0 * scale_of(arm).torque
    place, ratio = _place(arm, j, rng), float(rng.uniform(1.2, 3.0))
    return Outside(
        "gas_spring",
        (j + 1,),
        "position",
        lambda s: ((), (GasSpring(_row(arm.joints, j, s * force[j]), place, ratio),)),
    )


def _tight_spot(arm: ArmTruth, rng: Rng) -> Outside:
    j = int(rng.integers(arm.joints))
    level, place = 4.0 * scale_of(arm).torque[j], _place(arm, j, rng)
    width = float(rng.uniform(0.03, 0.12) * (arm.upper[j] - arm.lower[j]))
    slow = float(0.05 * arm.top_speed[j])
    return Outside(
        "tight_spot",
        (j + 1,),
        "position",
        lambda s: ((), (TightSpot(_row(arm.joints, j, s * level), place, width, slow),)),
    )


def _cubic_cable(arm: ArmTruth, rng: Rng) -> Outside:
    j = int(rng.integers(arm.joints))
    place, half = _place(arm, j, rng), (arm.upper[j] - arm.lower[j]) / 2
    most = 4.0 * scale_of(arm).torque[j] / half**3
    return Outside(
        "cubic_cable", (j + 1,), "position", lambda s: ((), (CubicCable(_row(arm.joints, j, s * most), place),))
    )


def _sensor_lag(arm: ArmTruth, rng: Rng) -> Outside:
    j = int(rng.integers(arm.joints))
    return Outside("sensor_lag", (j + 1,), "other", lambda s: ((), (SensorLag(_row(arm.joints, j, 0.15 * s)),)))


def _torque_dead_band(arm: ArmTruth, rng: Rng) -> Outside:
    j = int(rng.integers(arm.joints))
    most = 1.5 * scale_of(arm).torque[j]
    return Outside("torque_dead_band", (j + 1,), "load", lambda s: ((), (DeadBand(_row(arm.joints, j, s * most)),)))


def _swinging_load(arm: ArmTruth, rng: Rng) -> Outside:
    mass, length = 0.4 * scale_of(arm).mass, float(rng.uniform(0.08, 0.35))
    return Outside(
        "swinging_load", (), "other", lambda s: ((_effect("swinging_load", (), mass * s, length=length),), ())
    )


def _dropped_load(arm: ArmTruth, rng: Rng) -> Outside:
    scale, time = scale_of(arm), float(rng.uniform(6.0, 14.0))
    com = tuple(float(x) for x in scale.tool + 0.05 * scale.reach * rng.standard_normal(3))
    return Outside(
        "dropped_load", (), "time",
        lambda s: ((_effect("dropped_load", (), 0.5 * scale.mass * s, com=com, time=time),), ()),
    )  # fmt: skip


def _flexible_base(arm: ArmTruth, rng: Rng) -> Outside:
    """At most so soft that the whole arm, stretched out, rocks at three hertz."""
    scale = scale_of(arm)
    inertia = scale.mass * (0.6 * scale.reach) ** 2
    most = 1 / (inertia * (2 * np.pi * 3.0) ** 2)
    return Outside("flexible_base", (), "other", lambda s: ((_effect("flexible_base", (), most * s),), ()))


def _saturation(arm: ArmTruth, rng: Rng) -> Outside:
    j = int(rng.integers(arm.joints))
    peak = 1.8 * scale_of(arm).torque[j]
    knee = float(rng.uniform(2.0, 6.0))
    return Outside("saturation", (j + 1,), "load", lambda s: ((), (Saturation(_row(arm.joints, j, s / peak), knee),)))


def _changing_crosstalk(arm: ArmTruth, rng: Rng) -> Outside:
    n = arm.joints
    j = int(rng.integers(n))
    k = int(rng.choice([i for i in range(n) if i != j]))
    torque = scale_of(arm).torque
    mixing = np.zeros((n, n))
    mixing[j, k] = 1.5 * torque[j] / torque[k]
    period, phase = float(rng.uniform(6.0, 30.0)), float(rng.uniform(0, 2 * np.pi))
    return Outside(
        "changing_crosstalk", (j + 1,), "time", lambda s: ((), (ChangingCrossTalk(s * mixing, period, phase),))
    )


def _back_emf_limit(arm: ArmTruth, rng: Rng) -> Outside:
    j = int(rng.integers(arm.joints))
    free = float(rng.uniform(0.2, 0.5) * arm.top_speed[j])
    return Outside(
        "back_emf_limit", (j + 1,), "velocity", lambda s: ((), (BackEmf(_row(arm.joints, j, 0.5 * s), free),))
    )


def _effect(name: str, joints: tuple[int, ...], size: float, **shape: float | tuple[float, ...]) -> HiddenEffect:
    return HiddenEffect(effect=name, joints=joints, size=size, shape=dict(shape))


MAKERS: dict[str, Callable[[ArmTruth, Rng], Outside]] = {
    "backlash": _backlash,
    "gas_spring": _gas_spring,
    "tight_spot": _tight_spot,
    "cubic_cable": _cubic_cable,
    "sensor_lag": _sensor_lag,
    "torque_dead_band": _torque_dead_band,
    "swinging_load": _swinging_load,
    "dropped_load": _dropped_load,
    "flexible_base": _flexible_base,
    "saturation": _saturation,
    "changing_crosstalk": _changing_crosstalk,
    "back_emf_limit": _back_emf_limit,
}
