"""What rounding leaves of a column is no equation for its parameter."""

from __future__ import annotations

import numpy as np

import physident as pid
from physident.dynamics.model import Model
from physident.dynamics.regressor import build_regressor
from physident.estimation.quick_fit import quick_fit
from tests.sines import sines

LEAST = 1e-9  # of the largest column


def test_the_inertia_that_a_resting_joint_would_show_keeps_its_value(ur5: pid.Robot) -> None:
    """Joints 2 and 3 stand still: what is left of some columns is 1e-15, and any noise would make 1e14 kg m^2 of it."""
    rng, time = np.random.default_rng(4), np.arange(0.0, 20.0, 0.008)
    moves = np.array([1.0, 0.0, 0.0, 1.0, 1.0, 1.0])
    q, v, a = sines(rng, time, 3, 6, (0.5, 2.0), 0.3)
    q, v, a = moves * q + np.array([0.0, -1.2, 1.2, -1.2, -1.2, 0.0]), moves * v, moves * a
    effects = pid.make_effects(["rigid_body", "viscous_friction", "coulomb_friction", "torque_offset"])
    nominal = Model.nominal(ur5, effects)
    torque = nominal.torque(pid.Signals.of_states(q, v, a)) + 0.3 * rng.standard_normal(q.shape)
    recording = pid.Recording.from_arrays(time, q, dq=v, effort=torque)
    filter = pid.Filter()
    regressor = build_regressor(ur5, effects, [pid.prepare(recording, filter)], filter)
    size = np.linalg.norm(regressor.Y.reshape(-1, len(regressor.columns)), axis=0)
    assert ((size > 0) & (size < LEAST * size.max())).any()
    assert np.abs(quick_fit(ur5, effects, regressor)).max() < 1e6
