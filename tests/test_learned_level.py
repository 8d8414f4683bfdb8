"""More friction of a joint whose friction turns otherwise than any law does: the level changed, and a curve of its shape says no more."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from tests.serial_arms import ARMS, urdf
from tests.sines import sines

pytestmark = pytest.mark.slow

BEFORE, AFTER, OTHER = 2.0, 3.0, 2.0  # N m of joint 1 before and after, and of joint 2
TURN = 0.01  # rad/s: friction turns as v over the root of v^2 + TURN^2, slower than a hyperbolic tangent


def recorded(seed: int, level: float) -> pid.Recording:
    """Two joints with parallel axes along random motions; rigid torque by pinocchio."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 40.0, 0.004)
    model = pin.buildModelFromXML(urdf(ARMS["two"]))
    q, v, a = sines(rng, time, 4, 2, (0.5, 2.5), 0.25)
    data = model.createData()
    tau = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
    tau += np.array([level, OTHER]) * v / np.sqrt(v**2 + TURN**2) + 1.5 * v + 0.03 * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"{seed}")


@pytest.fixture(scope="module")
def answer(tmp_path_factory: pytest.TempPathFactory) -> pid.Diagnosis:
    path = tmp_path_factory.mktemp("level") / "two.urdf"
    path.write_text(urdf(ARMS["two"]))
    control = [recorded(seed, BEFORE) for seed in (1, 2)]
    estimate = pid.identify(pid.load_robot(path), control)
    return pid.diagnose_motion(estimate, [recorded(seed, AFTER) for seed in (3, 4)], before=control)


def test_the_level_is_the_change_though_the_shape_is_no_laws(answer: pid.Diagnosis) -> None:
    (cause,) = answer.causes
    assert (cause.effect, cause.joints) == ("coulomb_friction", (1,))
    (level,) = cause.parameters
    assert level.change == pytest.approx(AFTER - BEFORE, rel=0.05)


def test_a_change_is_known_better_than_the_value(answer: pid.Diagnosis) -> None:
    """What dry friction is beside the curve that the model found before, nothing tells, before or after; the change has no such doubt."""
    (level,) = answer.causes[0].parameters
    assert 0 < np.ptp(level.change_interval95) < 0.1 * np.ptp(level.interval95)


def test_what_the_shape_needs_beside_the_laws_was_there_before(answer: pid.Diagnosis) -> None:
    assert all(one.effect != "learned_velocity" for one in answer.findings)
    assert any(one.effect == "learned_velocity" and 2 in one.joints for one in answer.missing_since_before)
