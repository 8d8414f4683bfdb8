"""A physical fit does not depend on the units of its parameters: a stiffness counts by its torque, not by its size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import physident as pid
from physident.dynamics.regressor import build_regressor
from physident.estimation.regressor_fit import estimate_from

STIFFNESS, DISTANCE = 4e4, 2e-4  # N m/rad over rad: 8 N m of friction, in a number a thousand times as large
DRY = 3.0  # N m


def test_a_stiff_bristle_is_not_taken_for_dry_friction(ur5: pid.Robot) -> None:
    """Both are friction of one joint and nearly one column; noise-free data tell them apart, in any units."""
    effects = pid.make_effects(["rigid_body", "coulomb_friction", "presliding_hysteresis"])
    effects = (*effects[:2], replace(effects[2], distance=(DISTANCE,) * 6))
    theta = np.concatenate([ur5.nominal, np.full(6, DRY), np.full(6, STIFFNESS)])
    truth = pid.Model(ur5, effects, theta)
    filter, signals = pid.Filter(5.0), []
    for seed in (0, 1):
        time = np.arange(1500) / 100
        rng = np.random.default_rng(seed)
        rate, phase = rng.uniform(1, 4, (3, 6)), rng.uniform(0, 2 * np.pi, (3, 6))
        angle = time[:, None, None] * rate + phase
        q, v, a = (0.3 * np.sum(x, axis=1) for x in (np.sin(angle), rate * np.cos(angle), -(rate**2) * np.sin(angle)))
        motion = pid.Signals(time, q, v, a, rate=100.0, cutoff=5.0, source=f"motion {seed}", recording=str(seed))
        signals.append(replace(motion, torque=truth.torque(motion)))
    regressor = build_regressor(ur5, effects, signals, filter)
    found = estimate_from(ur5, effects, regressor, [], "physical", filter)
    np.testing.assert_allclose(found.model.parameters("presliding_hysteresis"), STIFFNESS, rtol=0.01)
    np.testing.assert_allclose(found.model.parameters("coulomb_friction"), DRY, rtol=0.05)
