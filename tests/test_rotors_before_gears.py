"""A rotor turns before its gear: it is no part of the load that the gear carries, and where torques tell it from no link, the links stay as described."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.effects.transmission import LoadDependentFriction
from tests.serial_arms import Joint, swinging, urdf

JOINTS = (
    Joint("0 0 1", mass=8.0, length=0.25), Joint("0 1 0", "0 0 0.15", mass=7.0, length=0.4), Joint("0 1 0", "0 0 0.4", mass=4.0)
)  # fmt: skip
ROTORS = np.array([1.4, 1.7, 0.6])  # kg m^2
DRY, SHARE = np.array([8.0, 9.0, 5.0]), np.array([0.0, 0.15, 0.1])  # N m, of the load
NOISE = 0.3  # N m


def run(number: int) -> pid.Recording:
    """Twenty seconds by pinocchio, with friction that grows with what the links alone need."""
    time = np.arange(0.0, 20.0, 0.004)
    _, _, links = swinging(np.random.default_rng(number), time, JOINTS, 0.25, (0.3, 5.0))
    rng = np.random.default_rng(number)
    q, v, tau = swinging(rng, time, JOINTS, 0.25, (0.3, 5.0), ROTORS)
    tau += (DRY + SHARE * np.abs(links)) * v / np.hypot(v, 0.004) + NOISE * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=str(number))


@pytest.fixture(scope="module")
def estimate(tmp_path_factory: pytest.TempPathFactory) -> pid.Estimate:
    path: Path = tmp_path_factory.mktemp("arm") / "arm.urdf"
    path.write_text(urdf(JOINTS))
    robot = pid.load_robot(path)
    effects = ["rigid_body", "rotor_inertia", "coulomb_friction", LoadDependentFriction(joints=(2, 3))]
    return pid.identify(robot, [run(number) for number in (1, 2, 3)], effects=effects)


def test_friction_grows_with_what_the_links_need(estimate: pid.Estimate) -> None:
    """Were the rotors part of the load, the friction of joint 2 would err by a tenth."""
    theta = dict(zip((c.name for c in estimate.model.columns), estimate.model.theta, strict=True))
    found = [theta[f"load_dependent_friction_{joint}"] for joint in (2, 3)]
    assert found == pytest.approx(SHARE[1:], rel=0.03)


def test_a_rotor_takes_what_no_motion_tells_from_a_link(estimate: pid.Estimate) -> None:
    """The inertia of rotors 1 and 2 about their joints is that of the links behind them, to any torque sensor."""
    model = estimate.model
    theta = dict(zip((c.name for c in model.columns), model.theta, strict=True))
    assert [theta[f"rotor_inertia_{j}"] for j in (1, 2, 3)] == pytest.approx(ROTORS, rel=0.06)
    stated = dict(
        zip((c.name for c in model.columns), pid.Model.nominal(model.robot, model.effects).theta, strict=True)
    )
    assert theta["Izz_1"] == pytest.approx(stated["Izz_1"], abs=0.02)
    assert theta["Iyy_2"] == pytest.approx(stated["Iyy_2"], abs=0.05)


def test_no_rotor_is_less_than_nothing_where_a_link_is_lighter_than_described(estimate: pid.Estimate) -> None:
    """Torques that are measured behind the gears hold no rotor: where a description's link has too much inertia, the link is wrong."""
    robot = estimate.model.robot
    model = pid.Model.nominal(robot, ["rigid_body", "rotor_inertia"])
    names = [column.name for column in model.columns]
    lighter = np.array(model.theta)
    lighter[[names.index("Izz_1"), names.index("Iyy_2")]] *= 0.5
    base = pid.find_base_parameters(robot, model.effects)
    found = base.nearest(model.theta, base.values(lighter))
    np.testing.assert_allclose(base.values(found), base.values(lighter), atol=1e-9)
    assert [found[names.index(f"rotor_inertia_{joint}")] for joint in (1, 2)] == [0.0, 0.0]
