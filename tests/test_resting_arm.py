"""An arm that mostly rests: its rests say what friction's band leaves to say, and nothing else."""

from __future__ import annotations

import warnings

import cvxpy as cp
import numpy as np
import pytest

import physident as pid

RATE = 125.0
NOISE = 0.05  # N m
INERTIA, GRAVITY, VISCOUS, DRY = 0.42, 7.848, 0.8, 3.0  # kg m^2, N m, N m s/rad, N m
Array = np.ndarray
LINK = """<robot name="one"><link name="base"/>
<link name="a"><inertial><origin xyz="0.4 0 0"/><mass value="2"/>
 <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="one" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 -1 0"/>
 <limit lower="-3" upper="3" effort="100" velocity="4"/></joint></robot>"""
EFFECTS = ("rigid_body", "viscous_friction", "coulomb_friction", "torque_offset")


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    """One joint about a horizontal axis: it lifts 7.848 N m where it lies flat."""
    path = tmp_path_factory.mktemp("one") / "one.urdf"
    path.write_text(LINK)
    return pid.load_robot(path)


def visits(held: Array, seed: int = 0) -> tuple[Array, Array, Array, Array, Array]:
    """Time, q, v, a and torque (N,) of moves of a second with rests of five, at each of which friction holds ``held`` (K,) of
    its band."""
    rng = np.random.default_rng(seed)
    poses = np.r_[0.0, rng.uniform(-1.4, 1.4, len(held))]
    time = np.arange(round(6 * len(held) * RATE)) / RATE
    q, v, a, friction = (np.zeros(len(time)) for _ in range(4))
    for k, share in enumerate(held):
        x = np.clip(time - 6 * k, 0.0, 1.0)
        way = poses[k + 1] - poses[k]
        q += way * x**3 * (10 - 15 * x + 6 * x**2)
        v += way * 30 * (x * (1 - x)) ** 2
        a += way * 60 * x * (1 - x) * (1 - 2 * x)
        inside = (time >= 6 * k) & (time < 6 * (k + 1))
        friction[inside] = np.where(v[inside] != 0, DRY * np.sign(v[inside]), DRY * share)
    torque = INERTIA * a + GRAVITY * np.cos(q) + VISCOUS * v + friction
    return time, q, v, a, torque + NOISE * rng.standard_normal(len(time))


def identified(arm: pid.Robot, held: Array, method: str = "wls", seed: int = 0) -> pid.Estimate:
    time, q, v, _, torque = visits(held, seed)
    step = 2e-6  # an encoder of 21 bits
    recording = pid.Recording.from_arrays(time, step * np.round(q[:, None] / step), torque[:, None], v[:, None])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # ten moves are few independent samples
        return pid.identify(arm, recording, effects=EFFECTS, method=method)


def friction_of(estimate: pid.Estimate) -> tuple[float, float]:
    """Value and standard error of the dry friction."""
    names = [estimate.base.columns[i].name for i in estimate.base.independent]
    at = names.index("coulomb_friction_1")
    return estimate["coulomb_friction_1"], float(np.sqrt(estimate.covariance[at, at]))


@pytest.mark.parametrize("method", ["wls", "robust", "physical"])
def test_what_friction_holds_inside_its_band_says_nothing(arm: pid.Robot, method: str) -> None:
    """Rests whose torque lies anywhere inside the band leave the estimate where the moves put it."""
    rng = np.random.default_rng(3)
    estimates = [
        identified(arm, held, method) for held in (np.zeros(10), 0.9 * rng.uniform(-1, 1, 10), np.full(10, 0.9))
    ]
    for estimate in estimates:
        value, std = friction_of(estimate)
        assert value == pytest.approx(DRY, rel=0.015)  # its scatter over sixteen draws of the noise is 0.6 %
        assert std < 0.03 * DRY
        assert estimate["viscous_friction_1"] == pytest.approx(VISCOUS, rel=0.03)
        assert abs(estimate["torque_offset_1"]) < 0.01 * GRAVITY


def test_nearer_to_the_truth_than_a_latent_torque_for_each_sample(arm: pid.Robot) -> None:
    """cvxpy solves for the parameters and a friction torque inside the band for every sample at rest, all at once.

    Both agree within the noise that such a program takes for friction: it widens the band until it holds the noise's peaks.
    """
    held = np.array([1.0, 0.2, -1.0, 0.5, -0.3, 1.0, -1.0, 0.0, -0.8, 1.0])
    time, q, v, a, torque = visits(held)
    columns = np.column_stack([a, np.cos(q), np.sin(q), v, np.sign(v), np.ones(len(time))])
    theta, latent = cp.Variable(6), cp.Variable(len(time))
    rests = v == 0
    constraints = [cp.abs(latent[rests]) <= theta[4], latent[~rests] == 0]
    error = cp.sum_squares((torque - columns @ theta - latent) / NOISE)
    cp.Problem(cp.Minimize(error), constraints).solve(solver=cp.CLARABEL)
    assert theta.value is not None
    estimate = identified(arm, held)
    value, _ = friction_of(estimate)
    assert abs(value - theta.value[4]) < NOISE
    assert abs(value - DRY) < abs(theta.value[4] - DRY)
    assert abs(estimate["torque_offset_1"] - theta.value[5]) < NOISE


def test_rests_at_the_edge_of_the_band_are_equations(arm: pid.Robot) -> None:
    """An arm that sags until friction holds it shows the level of its friction; one that rests inside the band does not."""
    sides = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    edge, inside = (np.mean([friction_of(identified(arm, k * sides, seed=s))[1] for s in range(3)]) for k in (1.0, 0.5))
    assert edge < inside
