"""Physically consistent estimates: named convex problems with known answers, and what no real arm may be."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor
from physident.effects.catalogue import DEFAULT_EFFECTS, make_effects
from physident.effects.effect import Column
from physident.effects.friction import NonlinearViscousFriction
from physident.errors import NotSolvedError, PhysidentWarning
from physident.estimation.estimators import OLS, WLS, Physical
from physident.estimation.physical.bounds import Bound, Box, Ellipsoid, volume_rows
from physident.estimation.physical.certificate import Multipliers, check_optimality, condition_number
from physident.estimation.physical.cones import Cones, physical_cones
from physident.estimation.physical.coordinates import SQUARES, TRACES, UNITS, Coordinates
from physident.estimation.physical.prior import Entropic, NominalDistance, NoPrior, Prior, solid_link
from physident.estimation.physical.problem import PhysicalProblem
from physident.estimation.physical.semidefinite_program import SemidefiniteProgram
from physident.estimation.regressor_fit import estimate_from
from physident.estimation.weighting import Compressed
from physident.recordings.signals import Filter, Signals
from physident.robots.inertia import PARAMETER_NAMES, PARAMETER_UNITS, link_parameters, pseudo_inertia
from tests.conftest import UR10E_COLUMNS, UR10E_GAINS

FILTER = Filter(5.0)
LINK = tuple(Column(f"{p}_1", u, 1, "rigid_body") for p, u in zip(PARAMETER_NAMES, PARAMETER_UNITS, strict=True))
BODY = np.array([3.0, 0.1, -0.2, 0.3, 0.2, 0.01, 0.25, -0.02, 0.03, 0.22])


def no_cones(p: int) -> Cones:
    return Cones(
        rows=np.zeros((0, p)),
        offsets=np.zeros(0),
        matrices=(),
        equal=np.zeros((0, p)),
        targets=np.zeros(0),
        labels=(),
    )


def link_problem(prior: Prior, measured: np.ndarray) -> tuple[SemidefiniteProgram, Coordinates]:
    """A program over one link whose data are |measured u - z|^2 / 2 in coordinates u of X."""
    coordinates = Coordinates.around(BODY, LINK)
    cone = replace(physical_cones(pid.load_robot("ur5"), make_effects(["rigid_body"])).matrices[0], link=1)
    one = replace(cone, map=cone.map[:, :, :10])
    cones = replace(no_cones(10), matrices=(one,))
    K = np.asarray(measured @ np.linalg.inv(coordinates.T), dtype=np.float64)
    return SemidefiniteProgram(PhysicalProblem(K, coordinates, cones, prior)), coordinates


def test_no_data_leaves_the_nominal() -> None:
    program, _ = link_problem(Entropic(), np.zeros((1, 10)))
    answer = program.solve(Compressed(np.zeros((1, 1)), np.zeros(1), 1.0, 1), 1.0)
    np.testing.assert_allclose(answer.u, TRACES, atol=1e-4)


@pytest.mark.parametrize(("z", "w"), [(6.0, 0.5), (1.0, 2.0), (40.0, 0.01)])
def test_entropic_fit_of_a_trace(z: float, w: float) -> None:
    """(tr X - z)^2 / 2 + w (tr X - log det X - 4): X = x 1 with 4 x^2 + (w - z) x - w = 0, by hand."""
    program, coordinates = link_problem(Entropic(), TRACES[None, :])
    answer = program.solve(Compressed(np.eye(1), np.array([z]), 0.0, 1), w)
    x = ((z - w) + np.sqrt((z - w) ** 2 + 16 * w)) / 8
    np.testing.assert_allclose(coordinates.link(answer.u, slice(0, 10)), x * np.eye(4), atol=1e-3 * max(1, x))
    assert answer.optimality.gap < 1e-6


def test_nearest_positive_semidefinite_matrix() -> None:
    """|X - A|^2 over the cone is the eigenvalue projection (Higham, 1988)."""
    A = np.diag([2.0, 1.0, -0.5, 0.3])
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(4, 4)))[0]
    A = turn @ A @ turn.T
    root = np.sqrt(SQUARES)
    program, coordinates = link_problem(NoPrior(), np.diag(root))
    z = root * np.array([np.sum(A * unit) / np.sum(unit**2) for unit in UNITS])
    answer = program.solve(Compressed(np.eye(10), z, 0.0, 1), 1.0)
    values, vectors = np.linalg.eigh(A)
    nearest = (vectors * np.maximum(values, 0)) @ vectors.T
    np.testing.assert_allclose(coordinates.link(answer.u, slice(0, 10)), nearest, atol=1e-4)
    multiplier = answer.multipliers.projected().matrices[0]
    np.testing.assert_allclose(multiplier, nearest - A, atol=1e-4)  # the part that was cut off (Moreau)


def test_ridge_has_a_closed_form() -> None:
    """Inside the cones the weighted distance to nominal is a linear system."""
    rng = np.random.default_rng(1)
    A = np.triu(rng.normal(size=(10, 10))) + 2 * np.eye(10)
    z = A @ TRACES + 0.05 * rng.normal(size=10)
    program, _ = link_problem(NominalDistance(), np.eye(10))
    answer = program.solve(Compressed(A, z, 0.0, 1), 0.7)
    expected = np.linalg.solve(A.T @ A + 0.7 * np.diag(SQUARES), A.T @ z + 0.7 * SQUARES * TRACES)
    np.testing.assert_allclose(answer.u, expected, atol=1e-5)


def test_nonnegative_parameters_are_clipped_with_their_multiplier() -> None:
    columns = tuple(Column(f"rotor_inertia_{j}", "kg m^2", j, "rotor_inertia") for j in (1, 2, 3))
    target = np.array([2.0, -1.0, 0.5])
    cones = replace(no_cones(3), rows=np.eye(3), offsets=np.zeros(3), labels=("one", "two", "three"))
    coordinates = Coordinates.around(np.zeros(3), columns)
    program = SemidefiniteProgram(PhysicalProblem(np.eye(3), coordinates, cones, NoPrior()))
    answer = program.solve(Compressed(np.eye(3), target, 0.0, 1), 1.0)
    np.testing.assert_allclose(answer.u, np.maximum(target, 0), atol=2e-6)
    np.testing.assert_allclose(answer.multipliers.rows, [0, 1, 0], atol=1e-6)


def test_the_proof_sees_what_is_wrong() -> None:
    """min (u - 1)^2 / 2 with u >= 2: optimal at 2 with multiplier 1; every tampering raises one residual."""
    rows = (np.eye(1), np.array([-2.0]))

    def residuals(u: float, y: float) -> tuple[float, float, float]:
        found = check_optimality(
            u=np.array([u]),
            multipliers=Multipliers(rows=np.array([y]), matrices=(), equalities=np.zeros(0)),
            gradient=np.array([u - 1.0]),
            gradient_sizes=np.array([u + 1.0]),
            objective=0.5 * (u - 1) ** 2,
            rows=rows,
            matrices=[],
            equalities=(np.zeros((0, 1)), np.zeros(0)),
        )
        return found.primal, found.dual, found.gap

    assert max(residuals(2.0, 1.0)) < 1e-12
    assert residuals(1.5, 0.5)[0] > 0.1  # outside
    assert residuals(2.0, 0.2)[1] > 0.1  # not stationary
    assert residuals(3.0, 2.0)[2] > 0.1  # stationary, not complementary
    assert residuals(2.0, -1.0)[1] > 0.1  # a negative multiplier is not taken


def test_data_that_are_no_numbers_end_in_a_named_error() -> None:
    program, _ = link_problem(Entropic(), TRACES[None, :])
    with pytest.raises(NotSolvedError, match=r"not optimal|unbounded"):
        program.solve(Compressed(np.eye(1), np.array([np.inf]), 0.0, 1), 1.0)


# --- a whole arm ---------------------------------------------------------------------------------------------------


def regress(model: Model, seed: int, duration: float, noise: float, robot_filter: Filter = FILTER) -> Regressor:
    t, q, v, a = pid.random_trajectory(model.robot, seed=seed, duration=20.0).sample(100.0)
    keep = slice(300, 300 + int(100 * duration))
    motion = Signals(t[keep], q[keep], v[keep], a[keep], rate=100.0)
    sigma = noise * np.array([2.0, 3.0, 1.5, 0.4, 0.5, 0.5])
    torque = model.torque(motion) + sigma * np.random.default_rng(seed).normal(size=motion.q.shape)
    return build_regressor(model.robot, model.effects, [replace(motion, torque=torque)], robot_filter)


@pytest.fixture(scope="module")
def arm(ur5: pid.Robot) -> Model:
    """A UR5 whose links differ from their description, so that a prior is not simply right."""
    model = Model.nominal(ur5)
    theta, rng = model.theta.copy(), np.random.default_rng(5)
    for i in range(0, 60, 10):
        values, vectors = np.linalg.eigh(pseudo_inertia(theta[i : i + 10]))
        root = (vectors * np.sqrt(values)) @ vectors.T
        turn, directions = np.linalg.eigh(rng.normal(size=(4, 4)) + np.eye(4))[0:2]
        theta[i : i + 10] = link_parameters(root @ (directions * np.exp(0.2 * turn)) @ directions.T @ root)
    theta[60:] = np.concatenate([[1.2, 1.2, 0.9, 0.2, 0.2, 0.2], [9, 9, 6, 2.5, 2, 1.5], [7, 8, 7, 1, 2, 2], [0.1] * 6])
    return Model(ur5, model.effects, theta)


def fit(arm: Model, regressor: Regressor, method) -> pid.Estimate:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysidentWarning)  # two seconds give rough standard errors
        return estimate_from(arm.robot, arm.effects, regressor, [], method, FILTER)


def test_physical_pays_when_data_are_short_and_costs_nothing_when_long(arm: Model) -> None:
    unseen = regress(arm, 100, 15.0, 0.0)
    scale = unseen.torque.std(axis=0)

    def error(estimate: pid.Estimate) -> float:
        return float(np.sqrt(((unseen.predict(estimate.theta - arm.theta) / scale) ** 2).mean()))

    short = {"ols": [], "physical": []}
    for seed in range(4):
        regressor = regress(arm, seed, 2.0, 1.0)
        short["ols"].append(error(fit(arm, regressor, OLS())))
        short["physical"].append(error(fit(arm, regressor, Physical(resamples=0))))
    assert np.mean(short["physical"]) < 0.5 * np.mean(short["ols"])
    long = regress(arm, 7, 16.0, 0.05)
    assert error(fit(arm, long, Physical(resamples=0))) < 1.2 * error(fit(arm, long, WLS())) + 1e-3


@pytest.mark.parametrize("prior", [Entropic(), NominalDistance(), NoPrior()], ids=lambda p: p.name)
def test_every_answer_is_physical(prior: Prior, arm: Model) -> None:
    """By eigenvalues of each link computed here, on data so short that least squares returns no arm at all."""
    regressor = regress(arm, 1, 2.0, 1.0)
    assert fit(arm, regressor, OLS()).violations
    estimate = fit(arm, regressor, Physical(prior, resamples=0))
    for i in range(0, 60, 10):
        assert np.linalg.eigvalsh(pseudo_inertia(estimate.theta[i : i + 10]))[0] > 0
    assert (estimate.model.parameters("rotor_inertia") >= 0).all()
    assert estimate.violations == ()
    assert estimate.certificate.primal < 1e-7
    assert min(estimate.certificate.eigenvalues) > 0


def test_weight_moves_the_answer_from_data_to_nominal(arm: Model) -> None:
    regressor = regress(arm, 2, 16.0, 0.3)
    nominal = Model.nominal(arm.robot).theta

    def divergence(theta: np.ndarray) -> float:
        parts = [
            np.linalg.solve(pseudo_inertia(nominal[i : i + 10]), pseudo_inertia(theta[i : i + 10]))
            for i in range(0, 60, 10)
        ]
        return float(sum(np.trace(X) - np.linalg.slogdet(X)[1] - 4 for X in parts))

    away = [divergence(fit(arm, regressor, Physical(Entropic(w), resamples=0)).theta) for w in (1e-2, 1e1, 1e4)]
    assert away[0] > away[1] > away[2] > 0
    loose, tight = (fit(arm, regressor, Physical(Entropic(w), resamples=0)) for w in (1e-2, 1e5))
    assert np.sum(np.array(loose.base_shares) > 0.9) > np.sum(np.array(tight.base_shares) > 0.9)
    assert all(0 <= s <= 1 for s in (*loose.shares, *tight.shares))


def test_automatic_weight_trusts_a_true_nominal_more(arm: Model) -> None:
    regressor = regress(arm, 3, 16.0, 1.0)
    wrong = Model.nominal(arm.robot).theta.copy()
    wrong[:60] *= np.repeat([3, 0.3, 3, 0.3, 3, 0.3], 10)
    weights = [
        fit(arm, regressor, Physical(Entropic("auto", tuple(nominal)), resamples=0)).prior_weight
        for nominal in (arm.theta, wrong)
    ]
    assert weights[0] is not None
    assert weights[1] is not None
    assert weights[0] > weights[1]


def test_friction_dissipates_as_a_sum(ur5: pid.Robot) -> None:
    """A falling square term is kept while the sum resists; a joint that drives itself is not believed."""
    effects = (*make_effects(DEFAULT_EFFECTS), NonlinearViscousFriction(exponent=(2.0,) * 6))
    model = Model.nominal(ur5, effects)
    theta = model.theta.copy()
    theta[60:] = np.repeat([0.5, 6.0, 3.0, 0.0, -1.5], 6)
    sagging = Model(ur5, model.effects, theta)
    found = fit(sagging, regress(sagging, 4, 16.0, 0.01), Physical(NoPrior(), resamples=0))
    np.testing.assert_allclose(found.model.parameters("nonlinear_viscous_friction"), -1.5, atol=0.3)
    theta[60:] = np.repeat([0.5, 1.0, 0.5, 0.0, -3.0], 6)
    driving = Model(ur5, model.effects, theta)
    found = fit(driving, regress(driving, 4, 16.0, 0.01), Physical(NoPrior(), resamples=0))
    speeds = np.linspace(0.01, 3.1, 50)
    force = sum(
        np.asarray(e.friction(ur5, speeds)) * found.model.parameters(e.name)[:, None]
        for e in found.model.effects
        if e.name.endswith("friction")
    )
    assert np.min(force) > -0.02
    assert any("drives it" in text for text in found.active_constraints)


def test_known_total_mass_and_bounds_hold(arm: Model) -> None:
    regressor = regress(arm, 5, 10.0, 1.0)
    box = Box(3, (-0.05, -0.1, -0.1), (0.5, 0.1, 0.2))
    known = Physical(total_mass=25.0, bounds=(Bound("m_2", 8.0, 8.5),), bounding_volumes=(box,), resamples=0)
    estimate = fit(arm, regressor, known)
    masses = estimate.theta[:60:10]
    assert masses.sum() == pytest.approx(25.0, rel=1e-6)
    assert 8.0 - 1e-5 <= masses[1] <= 8.5 + 1e-5
    assert (volume_rows(box, estimate.model.columns) @ estimate.theta >= -1e-6).all()


def test_contradictions_are_named(arm: Model) -> None:
    regressor = regress(arm, 5, 10.0, 1.0)
    with pytest.raises(NotSolvedError, match=r"no arm satisfies.*(m_2 outside its bounds|total mass)"):
        fit(arm, regressor, Physical(total_mass=5.0, bounds=(Bound("m_2", 6.0),), resamples=0))
    with pytest.raises(NotSolvedError, match=r"m_4 outside its bounds|link 4 is not a rigid body"):
        fit(arm, regressor, Physical(bounds=(Bound("m_4", None, -1.0),), resamples=0))


def test_priors_that_do_not_fit_are_refused(arm: Model) -> None:
    regressor = regress(arm, 5, 4.0, 1.0)
    nominal = arm.theta.copy()
    with pytest.raises(pid.InputError, match="prior has 83 nominal values, expected 84"):
        fit(arm, regressor, Physical(Entropic(1.0, tuple(nominal[:83]))))
    nominal[13] = np.nan
    with pytest.raises(pid.InputError, match="prior is nan for mcz_2"):
        fit(arm, regressor, Physical(Entropic(1.0, tuple(nominal))))
    with pytest.raises(pid.InputError, match="unknown parameter 'm_9'"):
        fit(arm, regressor, Physical(bounds=(Bound("m_9", 1.0),)))
    with pytest.raises(pid.InputError, match="link 9"):
        fit(arm, regressor, Physical(bounding_volumes=(Box(9, (0, 0, 0), (1, 1, 1)),)))


@pytest.mark.parametrize("shape", [Ellipsoid(1, (0.1, 0, 0.2), (0.2, 0.3, 0.4)), Box(1, (-0.1, 0, 0), (0.2, 0.3, 0.1))])
def test_bounding_volumes_accept_what_is_inside_and_refuse_what_is_not(shape: Ellipsoid | Box) -> None:
    rng = np.random.default_rng(0)
    if isinstance(shape, Ellipsoid):
        directions = rng.normal(size=(200, 3))
        points = directions / np.linalg.norm(directions, axis=1)[:, None] * rng.random((200, 1)) ** (1 / 3)
        points, centre = points * shape.semi_axes + shape.centre, np.array(shape.centre)
    else:
        points = rng.uniform(shape.lower, shape.upper, size=(200, 3))
        centre = (np.array(shape.lower) + np.array(shape.upper)) / 2
    rows = volume_rows(shape, LINK)

    def body(points: np.ndarray) -> np.ndarray:
        one = np.column_stack([points, np.ones(len(points))])
        return link_parameters(one.T @ one / len(one))

    assert (rows @ body(points) >= 0).all()
    assert (rows @ body(centre + 3 * (points - centre)) < 0).any()
    assert (rows @ body(points + 1.0) < 0).any()


def test_a_link_without_extent_is_made_solid() -> None:
    """The last link of a TX40 as its makers describe it: a mass of 0.2 kg and no inertia at all."""
    point = np.zeros(10)
    point[:4] = 0.2, 0.01, 0.0, -0.004
    point[4:] = link_parameters(pseudo_inertia(point) + np.pad(np.outer(point[1:4], point[1:4]) / 0.2, (0, 1)))[4:]
    with pytest.warns(PhysidentWarning, match="link 6: nominal inertia"):
        solid = solid_link(point, "link 6")
    assert np.linalg.eigvalsh(pseudo_inertia(solid))[0] > 0
    np.testing.assert_allclose(solid[:4], point[:4])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_array_equal(solid_link(BODY, "link 1"), BODY)


def test_real_tx40_nominal_warns_for_its_last_link(data: Path) -> None:
    robot = pid.load_robot(data / "tx40/tx40_mdh_modified.urdf")
    model = Model.nominal(robot)
    with pytest.warns(PhysidentWarning, match="link 6"):
        Coordinates.around(model.theta, model.columns)


def test_real_ur10e_least_squares_is_no_arm_and_physical_is(data: Path) -> None:
    robot = pid.load_robot(data / "ur10e/ur10e.urdf")
    runs = pid.load_recordings(
        [data / f"ur10e/ur-20_02_{k}.csv" for k in ("06-20sec_5harm", "10-30sec_12harm")], UR10E_COLUMNS, UR10E_GAINS
    )
    assert pid.identify(robot, runs, method="ols").violations
    estimate = pid.identify(robot, runs, method=Physical(resamples=0))
    assert estimate.violations == ()
    assert 10 < estimate.theta[:60:10].sum() < 50  # kg: the arm weighs 33 with its base
    unseen = pid.load_recordings(data / "ur10e/ur-20_02_06-20sec_10harm.csv", UR10E_COLUMNS, UR10E_GAINS)
    wls = pid.validate(pid.identify(robot, runs), unseen).rms
    assert (pid.validate(estimate, unseen).rms < 1.1 * wls).all()


def test_directions_that_nothing_decides_have_no_part_in_the_condition_number() -> None:
    assert condition_number(np.array([4.0, 2.0, 0.5])) == 8.0
    assert condition_number(np.array([4.0, 2.0, 1e-160, 0.0])) == 2.0
