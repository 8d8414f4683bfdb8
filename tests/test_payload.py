"""A load on a known arm is found: its mass, where it sits, that it is a body, and what cannot be known of it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.robots.inertia import pseudo_inertia
from tests.conftest import UR10E_COLUMNS, UR10E_GAINS
from tests.loads import EFFECTS, arm, body, record

MOMENTS = (0.008, 0.009, 0.006)  # kg m^2, about axes through the centre
LOAD = body(2.6, (0.03, -0.02, 0.08), MOMENTS)


@pytest.fixture(scope="module")
def estimate(ur5: pid.Robot) -> pid.Estimate:
    """The arm as identified from two noisy unloaded recordings."""
    return pid.identify(ur5, [record(arm(ur5), seed) for seed in (1, 2)], EFFECTS)


@pytest.fixture(scope="module")
def loaded(ur5: pid.Robot) -> pid.Recording:
    return record(arm(ur5, LOAD), seed=3)


@pytest.fixture(scope="module")
def found(estimate: pid.Estimate, loaded: pid.Recording) -> pid.Payload:
    return pid.identify_payload(estimate, [loaded])


def test_mass_within_one_percent_and_centre_within_three_millimetres(found: pid.Payload) -> None:
    assert abs(found.mass / LOAD[0] - 1) < 0.01
    assert np.abs(found.centre - LOAD[1:4] / LOAD[0]).max() < 0.003
    assert found.visible


def test_intervals_hold_the_truth(found: pid.Payload) -> None:
    assert found.mass_interval[0] < LOAD[0] < found.mass_interval[1]
    inside = (found.intervals[:, 0] < LOAD) & (found.intervals[:, 1] > LOAD)
    assert inside.sum() >= 8  # of ten 95 % intervals: fewer happen once in a hundred
    assert (found.intervals[:, 0] <= found.parameters).all()
    assert (found.parameters <= found.intervals[:, 1]).all()
    low, high = found.moment_interval.T
    assert ((low < MOMENTS) & (high > MOMENTS)).sum() >= 2  # of three: fewer happen less than once in a hundred
    assert (low <= np.diag(found.inertia)).all()
    assert (np.diag(found.inertia) <= high).all()


def test_every_joint_that_feels_the_load_sees_the_same_mass(found: pid.Payload) -> None:
    mass, error = found.seen_by_joint.T
    assert np.isfinite(mass).sum() >= 3
    assert np.nanmax(np.abs(mass - LOAD[0]) / error) < 5


def test_a_point_mass_comes_out_as_a_body(ur5: pid.Robot, estimate: pid.Estimate) -> None:
    point = body(0.4, (0.0, 0.05, 0.1), (0.0, 0.0, 0.0))
    found = pid.identify_payload(estimate, [record(arm(ur5, point), seed=4)])
    assert np.linalg.eigvalsh(pseudo_inertia(found.parameters))[0] > -1e-9
    assert found.mass_interval[0] < 0.4 < found.mass_interval[1]
    assert found.inertia.trace() < 0.05


def test_no_load_is_said_not_to_be_visible(ur5: pid.Robot, estimate: pid.Estimate) -> None:
    found = pid.identify_payload(estimate, [record(arm(ur5), seed=5)])
    assert not found.visible
    assert "no load is visible" in repr(found)
    assert found.mass_interval[1] < 0.1


def test_mass_follows_the_scale_of_the_torque(estimate: pid.Estimate, loaded: pid.Recording) -> None:
    """An arm and a load measured with torques 7 % too high: the load is 7 % too heavy, and nothing shows it."""
    model = replace(estimate.model, theta=1.07 * estimate.theta)
    louder = replace(estimate, model=model, covariance=1.07**2 * estimate.covariance, sigma=1.07 * estimate.sigma)
    gained = replace(loaded, effort_kind="current", drive_gains=(1.07,) * 6)
    high, right = pid.identify_payload(louder, [gained]), pid.identify_payload(estimate, [loaded])
    np.testing.assert_allclose(high.mass, 1.07 * right.mass, rtol=1e-4)
    np.testing.assert_allclose(high.centre, right.centre, atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(high.sigma) / np.linalg.norm(right.sigma), 1.07, rtol=1e-3)
    assert "confounded" in high.scale
    assert "confounded" not in right.scale


def test_friction_that_grows_with_load_is_not_taken_for_mass(ur5: pid.Robot) -> None:
    """Load-dependent friction of a loaded joint is that of the loaded joint: exact states, so the load is exact."""
    effects = pid.make_effects([*EFFECTS, "load_dependent_friction"])
    true = pid.Model(ur5, effects, np.concatenate([arm(ur5).theta, np.full(6, 0.1)]))
    theta = np.array(true.theta)
    theta[50:60] += LOAD
    time, q, v, a = pid.random_trajectory(ur5, seed=7, duration=20.0).sample(500.0)
    torque = replace(true, theta=theta).torque(pid.Signals.of_states(q, v, a))
    free = pid.identify(ur5, [record(arm(ur5), 1)], EFFECTS)
    base = pid.find_base_parameters(ur5, effects)
    known = replace(free, model=true, covariance=1e-12 * np.eye(base.r))
    found = pid.identify_payload(known, [pid.Recording(time, q, torque, "torque", dq=v)])
    assert abs(found.mass / LOAD[0] - 1) < 2e-3
    np.testing.assert_allclose(found.centre, LOAD[1:4] / LOAD[0], atol=5e-4)


def test_recordings_that_cannot_show_a_load_are_refused(
    ur5: pid.Robot, estimate: pid.Estimate, loaded: pid.Recording
) -> None:
    with pytest.raises(pid.InputError, match="no recordings"):
        pid.identify_payload(estimate, [])
    fitted = replace(estimate, sources=(replace(estimate.sources[0], sha256=loaded.sha256),))
    with pytest.raises(pid.InputError, match="training recording"):
        pid.identify_payload(fitted, [loaded])
    plan = pid.random_trajectory(ur5, seed=6, duration=20.0)
    one = replace(plan, a=plan.a * np.eye(6)[:, :1], b=plan.b * np.eye(6)[:, :1])  # joint 1 alone, upright: Izz only
    time, q, v, a = one.sample(125.0)
    still = pid.Recording(time, q, arm(ur5, LOAD).torque(pid.Signals.of_states(q, v, a)), "torque", dq=v)
    with pytest.raises(pid.InputError, match=r"does not show .*mcx"):
        pid.identify_payload(estimate, [still])


def test_command_line_writes_what_it_prints(
    estimate: pid.Estimate, loaded: pid.Recording, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    model, recording, out = tmp_path / "m.json", tmp_path / "load.csv", tmp_path / "load.json"
    estimate.save(model)
    names = ["time", *(f"{kind}_{j}" for kind in ("q", "dq", "tau") for j in range(1, 7))]
    table = np.column_stack([loaded.time, loaded.q, loaded.dq, loaded.effort])  # pyright: ignore[reportArgumentType, reportCallIssue]
    np.savetxt(recording, table, "%.9g", delimiter=",", header=",".join(names), comments="")
    assert run(["payload", "--model", str(model), "--json", str(out), str(recording)]) == 0
    data = json.loads(out.read_text())
    assert f"a load of {data['mass_kg']:.3g} kg" in capsys.readouterr().out
    assert run(["payload", "--model", str(model), str(tmp_path / "nowhere.csv")]) == 2


def test_a_known_load_on_a_real_arm(data: Path) -> None:
    """A load that weighed 2.6 kg: with the published gains it comes out heavier than it was, and says it may."""
    robot = pid.load_robot(data / "ur10e" / "ur10e.urdf")
    folder = data / "ur10e"
    free = pid.load_recordings(str(folder / "ur-20_02_1*.csv"), UR10E_COLUMNS, UR10E_GAINS)
    carried = pid.load_recordings(folder / "ur-20_01_13-load_2600.csv", UR10E_COLUMNS, UR10E_GAINS)
    found = pid.identify_payload(pid.identify(robot, free), carried)
    assert 1.0 < found.mass / 2.6 < 1.15
    assert "confounded" in repr(found)
