"""A joint whose friction builds up over a distance gets more friction: presliding and Coulomb friction are two names for it."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

import physident as pid
from physident.effects.hysteresis import PreslidingHysteresis
from tests.serial_arms import ARMS, urdf

pytestmark = pytest.mark.slow

LEVEL, MORE = 2.0, 0.8  # N m on joint 1, and how much is added
ORDINARY = ("rigid_body", "viscous_friction", "coulomb_friction")
YIELD = (0.004, 0.008, 0.012, 0.016)  # rad: where each of the sliders in parallel gives way


def held_by_sliders(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Friction (N,) of one, of springs in parallel that each slip once they are stretched by so much (Maxwell slip)."""
    stretched, shares = np.zeros(len(YIELD)), np.zeros(len(q))
    for i in range(1, len(q)):
        stretched = np.clip(stretched + q[i] - q[i - 1], -np.array(YIELD), YIELD)
        shares[i] = np.mean(stretched / YIELD)
    return shares


def recorded(seed: int, level: float, duration: float = 40.0) -> pid.Recording:
    """Two joints with parallel axes, whose first one's friction has some level [N m]; rigid torque by pinocchio."""
    rng, time, model = (
        np.random.default_rng(seed),
        np.arange(0.0, duration, 0.004),
        pin.buildModelFromXML(urdf(ARMS["two"])),
    )
    omega, phase = rng.uniform(0.8, 4.0, (4, 2)), rng.uniform(0, 2 * np.pi, (4, 2))
    angle = time[:, None, None] * omega + phase
    q, v, a = (0.1 * part.sum(axis=1) for part in (np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle)))
    data = model.createData()
    tau = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
    tau[:, 0] += level * held_by_sliders(q[:, 0])
    tau += 2.0 * v + 0.05 * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"{seed}")


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    path = tmp_path_factory.mktemp("sliders") / "planar.urdf"
    path.write_text(urdf(ARMS["two"]))
    return pid.load_robot(path)


def test_more_friction_that_builds_up_as_before_is_coulomb_friction_by_another_name(robot: pid.Robot) -> None:
    effects = pid.make_effects([*ORDINARY, PreslidingHysteresis((1,), (0.01,))])
    model = pid.identify(robot, [recorded(1, LEVEL), recorded(2, LEVEL)], effects)
    answer = pid.diagnose_motion(model, [recorded(3, LEVEL + MORE)])
    first = answer.findings[0]
    assert first.grade == "cause"
    assert {first.effect, *(r.effect for r in first.rivals)} == {"presliding_hysteresis", "coulomb_friction"}
    assert first.joints == (1,)
    assert all(r.inseparable for r in first.rivals)
    (size,) = first.parameters
    (held,) = [e for e in model.model.effects if isinstance(e, PreslidingHysteresis)]
    assert held.distance is not None
    assert size.change is not None
    assert size.change * held.distance[0] == pytest.approx(MORE, rel=0.15)


def test_friction_that_begins_to_build_up_is_not(robot: pid.Robot) -> None:
    """A model without a distance: that friction follows one now is what is new."""
    model = pid.identify(robot, [recorded(1, 0.0), recorded(2, 0.0)])
    answer = pid.diagnose_motion(model, [recorded(3, LEVEL)])
    first = answer.findings[0]
    assert (first.effect, first.joints, first.grade) == ("presliding_hysteresis", (1,), "cause")
    assert "coulomb_friction" not in {r.effect for r in first.rivals}
