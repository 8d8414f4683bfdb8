"""More dry friction is named along motions that are smaller and slower than those of the model, where how it turns is most of the motion."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from tests.sines import sines

pytestmark = pytest.mark.slow

COULOMB = np.array([7.0, 8.5, 7.5, 1.5, 1.8, 2.2])  # N m
VISCOUS = np.array([9.0, 8.0, 6.5, 2.2, 2.0, 1.6])  # N m s/rad
ROTORS = np.array([1.1, 1.1, 0.8, 0.2, 0.2, 0.2])  # kg m^2
NOISE = np.array([0.3, 0.3, 0.25, 0.1, 0.1, 0.1])  # N m
MORE = 1.5
MIDDLE = np.array([0.0, -1.2, 1.2, -1.2, -1.2, 0.0])  # rad


def recorded(seed: int, size: float = 1.0, joint: int = 0) -> pid.Recording:
    """A UR5 along random motions of a ``size``, rigid torque by pinocchio; friction turns like v / sqrt(v^2 + w^2), and a ``joint`` has more."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 30.0, 0.008)
    model = pid.load_robot("ur5").pinocchio.copy()
    q, v, a = sines(rng, time, 4, 6, (0.4, 2.2), 0.3 * size)
    q, data = q + MIDDLE, model.createData()
    tau = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)]) + ROTORS * a
    level = COULOMB * np.where(np.arange(6) == joint - 1, MORE, 1.0)
    tau += level * v / np.sqrt(v**2 + 0.01**2) + VISCOUS * v + NOISE * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"motion {seed}")


@pytest.fixture(scope="module")
def healthy(ur5: pid.Robot) -> pid.Estimate:
    return pid.identify(ur5, [recorded(seed) for seed in (1, 2, 3)])


@pytest.mark.parametrize(("joint", "size"), [(3, 0.3), (5, 0.15), (1, 0.15)])
def test_more_dry_friction_is_no_curve(healthy: pid.Estimate, joint: int, size: float) -> None:
    """Neither over velocity, which holds how friction turns as well, nor over the torque, which takes few values then."""
    found = pid.diagnose_motion(healthy, [recorded(seed, size, joint) for seed in (4, 5)])
    assert [(f.effect, f.joints) for f in found.causes] == [("coulomb_friction", (joint,))]
