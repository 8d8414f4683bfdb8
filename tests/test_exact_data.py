"""Noise-free recordings, as a simulator writes them, are the easiest case for every method and for the search."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.special import erf

import physident as pid
from physident.recordings.channels import Channels
from physident.recordings.recording import recording_from_rows
from tests.bad_input.good import URDF
from tests.plant import multisine
from tests.plant_mujoco import MujocoPlant
from tests.truth import ArmTruth, FrictionTruth

pytestmark = pytest.mark.slow

COULOMB = np.array([7.7, 8.3, 7.8, 1.4, 2.0, 2.1])
VISCOUS = np.array([9.0, 9.0, 6.0, 2.5, 2.0, 1.5])
ROTOR = np.array([1.2, 1.2, 0.9, 0.21, 0.21, 0.21])
Size = float | np.ndarray
WIDTH = 0.008  # rad/s: one of the widths that the estimator tries
SHORT, LONG = 10.0, 20.0  # s: exact data need no length, what is averaged out of noise does
METHODS = ("ols", "wls", "robust", "physical")


def exact(
    robot: pid.Robot,
    seed: int,
    coulomb: Size = 0.0,
    viscous: Size = 0.0,
    rotor: Size = 0.0,
    noise: float = 0.0,
    duration: float = SHORT,
) -> pid.Recording:
    """A recording whose torque is Pinocchio's and closed-form friction to the last digit."""
    time, q, v, a = pid.random_trajectory(robot, seed=seed, duration=duration, base_frequency=0.1).sample(125.0)
    data = robot.pinocchio.createData()
    torque = np.array([pin.rnea(robot.pinocchio, data, *s).copy() for s in zip(q, v, a, strict=True)])
    # friction turns by the estimator's own law: exact data are exact for the model too
    torque += coulomb * erf(np.sqrt(np.pi) * v / (2 * WIDTH)) + viscous * v + rotor * a
    torque += noise * np.random.default_rng(seed).standard_normal(torque.shape)
    return recording_from_rows(Channels(time=time, q=q, effort=torque, effort_kind="torque", dq=v), f"exact {seed}")


@pytest.fixture(scope="module")
def two_joints(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    path = tmp_path_factory.mktemp("arm") / "arm.urdf"
    path.write_text(URDF)
    return pid.load_robot(path)


@pytest.mark.parametrize("method", METHODS)
def test_two_joints_are_identified_to_the_interpolation(method: str, two_joints: pid.Robot) -> None:
    runs = [exact(two_joints, seed, 1.0, 0.5) for seed in (1, 2)]
    estimate = pid.identify(two_joints, runs, method=method)
    assert (
        pid.validate(estimate, [exact(two_joints, 9, 1.0, 0.5)]).relative.max() < 0.1
    )  # percent: the model's sign is a mean over a sample, the recording's one instant
    np.testing.assert_allclose(estimate.model.parameters("coulomb_friction"), 1.0, rtol=1e-3)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_an_arm_without_friction_and_rotors_is_identified(method: str, noise: float, ur5: pid.Robot) -> None:
    """The truth lies on the boundary of every cone of friction and rotors at once."""
    runs = [exact(ur5, seed, noise=noise, duration=LONG) for seed in (1, 2)]
    estimator = pid.Physical(resamples=0) if method == "physical" else method
    estimate = pid.identify(ur5, runs, method=estimator)
    rms = pid.validate(estimate, [exact(ur5, 9)]).rms
    assert rms.max() < max(0.1 * noise, 2e-3)
    assert np.abs(estimate.model.parameters("rotor_inertia")).max() < max(noise, 1e-3)


@pytest.mark.parametrize("method", METHODS)
def test_exact_data_are_no_harder_than_noisy_ones(method: str, ur5: pid.Robot) -> None:
    """Iterations, which noise does not shorten."""
    needed = [
        pid.identify(
            ur5,
            [exact(ur5, seed, COULOMB, VISCOUS, noise=noise) for seed in (1, 2)],
            method=pid.Physical(resamples=0) if method == "physical" else method,
        ).certificate.iterations
        for noise in (0.0, 0.2)
    ]
    assert needed[0] <= needed[1]


def test_what_a_simulator_lacks_is_named_and_nothing_else(ur5: pid.Robot) -> None:
    runs = [exact(ur5, seed, COULOMB, rotor=ROTOR) for seed in (1, 2, 3)]
    with warnings.catch_warnings(action="ignore", category=pid.PhysidentWarning):
        found = pid.diagnose_motion(pid.Model.nominal(ur5, ["rigid_body"]), runs[:2], runs[2:])
    assert {finding.effect for finding in found.causes} == {"coulomb_friction", "rotor_inertia"}
    for finding, truth in ((f, COULOMB if f.effect == "coulomb_friction" else ROTOR) for f in found.causes):
        assert finding.joints == (1, 2, 3, 4, 5, 6)
        np.testing.assert_allclose([value.value for value in finding.parameters], truth, rtol=1e-2)
    assert found.verdict in ("explained", "partly_explained")  # the sign's mean over a sample leaves structure of 0.1 %


def test_a_change_is_named_alone_and_no_change_not_at_all(ur5: pid.Robot) -> None:
    with warnings.catch_warnings(action="ignore", category=pid.PhysidentWarning):
        before = pid.identify(ur5, [exact(ur5, seed, COULOMB, VISCOUS, ROTOR) for seed in (1, 2)])
        more = COULOMB + np.array([0, 3.0, 0, 0, 0, 0])
        changed = pid.diagnose_motion(before, [exact(ur5, seed, more, VISCOUS, ROTOR) for seed in (4, 5)])
        same = pid.diagnose_motion(before, [exact(ur5, seed, COULOMB, VISCOUS, ROTOR) for seed in (6, 7)])
    assert [(f.effect, f.joints) for f in changed.causes] == [("coulomb_friction", (2,))]
    assert changed.causes[0].parameters[0].change == pytest.approx(3.0, rel=1e-2)
    assert (same.causes, same.verdict) == ((), "nothing_missing")
    assert same.incomplete == ()


def sticking(robot: pid.Robot, simulator: str, seed: int) -> pid.Recording:
    """A recording to the last digit of an arm whose joints stick, in MuJoCo or in this package's own simulation."""
    if simulator == "physident":
        model = pid.Model.nominal(robot, ("rigid_body", "rotor_inertia", "coulomb_friction"))
        theta = {"coulomb_friction": COULOMB, "rotor_inertia": ROTOR}
        values = [
            theta[c.effect][c.joint - 1] if c.effect in theta else x
            for c, x in zip(model.columns, model.theta, strict=True)
        ]  # pyright: ignore[reportOptionalOperand]
        model = replace(model, theta=np.array(values))
        return pid.simulate(
            model, pid.random_trajectory(robot, seed=seed, duration=SHORT, base_frequency=0.1), seed=seed
        )
    dry = FrictionTruth(kind="dry", coulomb=COULOMB, viscous=np.zeros(6), breakaway=COULOMB, stribeck_speed=np.ones(6),
                        bristle_stiffness=np.ones(6), bristle_damping=np.zeros(6), width=np.ones(6), per_degree=np.zeros(6))  # fmt: skip
    arm = ArmTruth(name="ur5", urdf=robot.urdf, tool="tool0", links=robot.nominal.reshape(6, 10), rotor_inertia=ROTOR,
                   torque_offset=np.zeros(6), friction=dry, lower=np.full(6, -2.2), upper=np.full(6, 2.2),
                   top_speed=np.full(6, 1.5), top_acceleration=np.full(6, 3.0), bandwidth=40.0)  # fmt: skip
    run = MujocoPlant().simulate(arm, multisine(seed, duration=SHORT))
    every = round(1 / 125 / (run.time[1] - run.time[0]))
    return pid.Recording.from_arrays(run.time[::every], run.q[::every], run.torque[::every], run.v[::every])


@pytest.mark.parametrize("simulator", ["mujoco", "physident"])
def test_exact_recordings_of_an_arm_that_sticks_show_what_it_has_and_nothing_else(
    simulator: str, ur5: pid.Robot
) -> None:
    runs = [sticking(ur5, simulator, seed) for seed in (1, 2, 3)]
    with warnings.catch_warnings(action="ignore", category=pid.PhysidentWarning):
        found = pid.diagnose_motion(pid.Model.nominal(ur5, ["rigid_body"]), runs[:2], runs[2:])
    assert {finding.effect for finding in found.causes} == {"coulomb_friction", "rotor_inertia"}
    for finding, truth in ((f, COULOMB if f.effect == "coulomb_friction" else ROTOR) for f in found.causes):
        values = [value.value for value in finding.parameters]
        np.testing.assert_allclose(values, truth[np.array(finding.joints) - 1], rtol=0.03)


def test_all_placebos_passing_is_a_refusal() -> None:
    from physident.diagnosis.result.findings import Placebo
    from physident.diagnosis.search.side_results import refuse_if_placebos_pass

    passing, failing = Placebo("placebo", 1, 9.0, 1.0), Placebo("placebo", 2, 0.0, 1.0)
    refuse_if_placebos_pass([passing, failing])
    refuse_if_placebos_pass([])
    with pytest.raises(pid.NotSolvedError, match="all 2 placebos"):
        refuse_if_placebos_pass([passing, passing])
