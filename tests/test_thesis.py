"""The thesis study: its references, its way of fitting, its lists of base parameters, and what ours makes of them."""

from __future__ import annotations

import json

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from studies.thesis import bases, currents, dh_calibration, models, ours, plant, published, reference, trajectories
from studies.thesis.halves import HALVES, from_dh_frames, half, pseudo_inertia, ur5_table
from studies.thesis.thesis_way import identify_half, identify_whole_by_halves, predict_halves
from tests.conftest import ROOT


@pytest.fixture(scope="module")
def thesis() -> pid.Trajectory:
    return published.trajectory()


@pytest.fixture(scope="module")
def second(ur5: pid.Robot) -> pid.Trajectory:
    return pid.random_trajectory(ur5, seed=11, base_frequency=0.15)


def test_condition_numbers_of_the_thesis_trajectories(ur5: pid.Robot, thesis: pid.Trajectory) -> None:
    """The reported costs, 99.9 and 26.6, are those of cond(Y_B), not of its square as eq. 3.59 has it."""
    found = trajectories.conditions(ur5, thesis)
    for name, reported in published.COST.items():
        assert abs(np.log(found[name] / reported)) < 0.2, (name, found[name])
        assert abs(np.log(found[name] ** 2 / reported)) > 2


def test_the_thesis_trajectory_breaks_its_own_boundary_conditions(ur5: pid.Robot, thesis: pid.Trajectory) -> None:
    start = thesis.states(np.zeros(1))
    omega = 0.3 * np.pi
    assert start.v[0, 1] == pytest.approx(omega * published.SINES[1] @ np.arange(1, 6))
    assert start.v[0, 1] > 0.9
    assert min(abs(start.a[0, [2, 5]])) > 0.4
    assert not thesis.violations(ur5)


@pytest.mark.parametrize("name", HALVES)
def test_moving_to_dh_frames_is_pinocchios_frame_change(name: str) -> None:
    """Link parameters moved by the linear map equal Pinocchio's own change of frame."""
    T, rng = from_dh_frames(name), np.random.default_rng(3)
    for i, joint in enumerate(ur5_table()["joints"][HALVES[name]]):
        body = pin.Inertia.Random()
        alpha = np.radians(joint["alpha_deg"])
        frame = pin.SE3(pin.rpy.rpyToMatrix(alpha, 0.0, 0.0), np.array([joint["a"], 0.0, joint["d"]]))
        block = T[10 * i : 10 * i + 10, 10 * i : 10 * i + 10]
        np.testing.assert_allclose(block @ body.toDynamicParameters(), (frame * body).toDynamicParameters(), atol=1e-12)
    link = rng.standard_normal(10)
    assert pseudo_inertia(link)[3, 3] == link[0]


@pytest.mark.parametrize("name", HALVES)
def test_the_mended_lists_span_the_same_space_and_the_printed_ones_do_not(name: str) -> None:
    found = bases.compare(name, seed=5)
    assert found.ours.r == found.theirs.r == 15
    assert found.angle < 1e-10
    assert bases.printed_rank(name) < 15
    # both groupings describe the same combinations of standard parameters
    order = [found.theirs.columns.index(c) for c in found.ours.columns]
    both = np.vstack([found.ours.grouping, found.theirs.grouping[:, order]])
    assert np.linalg.matrix_rank(both) == 15


def test_errata_of_table_2_4() -> None:
    """About the link frames, link 2's inertia would be negative at its centre of mass; I_5zz as printed is no body's."""
    link = ur5_table()["joints"][1]
    x, y, z = link["com"]
    moved = np.array([link["inertia"][k] for k in (0, 2, 5)]) - link["mass"] * np.array(
        [y * y + z * z, x * x + z * z, x * x + y * y]
    )
    assert moved.min() < 0
    ixx, _, iyy, _, _, izz = ur5_table()["joints"][4]["inertia"]
    assert ixx + iyy > izz == 0.0009
    assert ixx + iyy < 0.009


def test_angle_sees_a_different_space() -> None:
    A = np.eye(4)[:, :2]
    tilted = np.column_stack([A[:, 0], np.cos(0.1) * A[:, 1] + np.sin(0.1) * np.eye(4)[:, 2]])
    assert bases.angle(A, 3.0 * A[:, ::-1]) < 1e-12
    assert bases.angle(A, tilted) == pytest.approx(0.1)
    assert bases.angle(A, A[:, :1]) == pytest.approx(np.pi / 2)


def test_model_a_gives_the_truth_back(ur5: pid.Robot, thesis: pid.Trajectory) -> None:
    """From analytic signals, the whole arm's base parameters equal the truth; the halves theirs."""
    whole = ours.identify(ur5, reference.run("a", thesis, ur5), "wls")
    true = whole.base.values(ours.truth(ur5, "a"))
    rigid = [i for i, k in enumerate(whole.base.independent) if whole.base.columns[k].effect == "rigid_body"]
    assert len(rigid) == 36
    np.testing.assert_allclose(whole.base.values(whole.theta), true, rtol=1e-6, atol=1e-9)
    for name in HALVES:
        found = identify_half(name, reference.half_run("a", thesis, name))
        np.testing.assert_allclose(found.values, found.base.values(half(name).nominal), rtol=1e-6, atol=1e-9)


def test_model_b_friction_comes_back_by_direction(
    ur5: pid.Robot, thesis: pid.Trajectory, second: pid.Trajectory
) -> None:
    """Table 2.5 times the gear ratio within 3 %, because the thesis takes the sign at an instant and the model its
    mean over a sample, and the thesis' way cannot predict a joint whose torque is friction."""
    found = models.compare("b", ur5, {"thesis": thesis, "designed": thesis, "validation": second})
    estimate = found.estimates["ours, wls, thesis trajectory"].estimate
    assert estimate is not None
    coulomb, offset = (estimate.model.parameters(e) for e in ("coulomb_friction", "torque_offset"))
    np.testing.assert_allclose(coulomb, published.COULOMB, rtol=0.03)
    by_direction = published.GEAR_RATIO * published.MOTOR_FRICTION
    np.testing.assert_allclose(np.column_stack([coulomb + offset, offset - coulomb]), by_direction, rtol=0.03)
    assert (found.error("thesis, halves")[[0, 3, 4, 5]] > 50).all()
    assert (found.error("ours, wls, thesis trajectory") < 5).all()


def test_leaving_the_coupling_out_cannot_be_fitted_away(ur5: pid.Robot, thesis: pid.Trajectory) -> None:
    """On the very trajectory that was fitted the halves miss joint 4's torque, which the whole arm's model has exactly."""
    own = reference.run("a", thesis, ur5)
    predicted = predict_halves(identify_whole_by_halves(own), own)
    missed = np.linalg.norm(own.torque - predicted, axis=0) / np.linalg.norm(own.torque, axis=0)
    assert missed[3] > 0.5
    assert (missed > 1e-3).all()


def test_currents_there_and_back() -> None:
    """Eq. 4.7-4.9: no noise leaves the torque; 50 dB is 3.2e-3 A on the current, times K_T G in the torque at rest."""
    rng = np.random.default_rng(0)
    torque = rng.standard_normal((20_000, 6))
    gains = published.TORQUE_CONSTANT * published.GEAR_RATIO
    np.testing.assert_allclose(currents.to_current(torque) * gains, torque, rtol=1e-14)
    assert np.std(currents.with_noise(torque, 50.0, rng) - torque) == pytest.approx(10**-2.5, rel=0.02)
    at_rest = currents.measured_torque(np.zeros((20_000, 6)), rng)
    np.testing.assert_allclose(at_rest.std(axis=0), 10**-2.5 * gains, rtol=0.05)
    loaded = currents.measured_torque(np.full((20_000, 6), 50.0), rng)
    expected = np.hypot(10**-2.5 * gains, 50.0 * 10**-2.5 / published.TORQUE_CONSTANT)
    np.testing.assert_allclose(loaded.std(axis=0), expected, rtol=0.05)


def test_calibrated_geometry_is_the_dh_table_with_its_offsets(ur5: pid.Robot) -> None:
    """The tool of the calibrated robot is where eq. 2.2 puts it for the corrected table, millimetres from the other."""
    rng, q = np.random.default_rng(0), np.array([0.3, -1.1, 0.9, 0.4, -0.7, 1.2])
    A = np.eye(4)
    for joint, angle in zip(ur5_table()["joints"], q, strict=True):
        d, a = dh_calibration.LENGTH * rng.standard_normal(2) + [joint["d"], joint["a"]]
        alpha, offset = np.radians(dh_calibration.ANGLE * rng.standard_normal(2) + [joint["alpha_deg"], 0.0])
        c, s, ca, sa = np.cos(angle + offset), np.sin(angle + offset), np.cos(alpha), np.sin(alpha)
        A = A @ np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])
    places = []
    for robot in (dh_calibration.calibrated(), ur5):
        data = robot.pinocchio.createData()
        pin.framesForwardKinematics(robot.pinocchio, data, q)
        places.append(data.oMf[robot.pinocchio.getFrameId("tool0")].translation.copy())
    np.testing.assert_allclose(places[0], A[:3, 3], atol=1e-9)
    assert 1e-4 < np.linalg.norm(places[0] - places[1]) < 1e-2


def test_the_independent_plant_has_table_2_5(ur5: pid.Robot, second: pid.Trajectory) -> None:
    """Recorded by the plant and identified with the default effects, Coulomb friction is Table 2.5's within 1 %; near zero
    speed the study's arm turns its friction as those effects assume."""
    estimate = pid.identify(ur5, [plant.recorded(plant.arm(True), second, 0, False, "plant")])
    np.testing.assert_allclose(estimate.model.parameters("coulomb_friction"), published.COULOMB, rtol=0.03)


def test_kept_results_hold_what_the_study_claims() -> None:
    """Model A to 1e-6, friction of model B to 1 %, D at the noise floor, intervals that cover: as the kept results say."""
    kept = json.loads((ROOT / "studies" / "thesis" / "results.json").read_text(encoding="utf-8"))
    assert {k: kept["base_parameters"][k] for k in ("whole", "bse", "w")} == {"whole": 36, "bse": 15, "w": 15}
    assert kept["model_a"]["base_parameters_off_relative"] < 1e-6
    assert max(map(abs, kept["model_b"]["friction_off_percent"])) < 1.0
    for model in "cd":
        ours, floor = (np.array(kept[f"model_{model}"][key]) for key in ("error_ours", "error_noise_alone"))
        assert (ours < 1.15 * floor).all(), model
        assert 90 < kept["coverage"][model]["designed"]["coverage_percent"] < 99
