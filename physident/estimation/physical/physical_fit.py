"""The physically consistent estimate: the size of the noise, the loss and the prior weight around the convex program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor
from physident.effects.effect import Effect
from physident.errors import NotSolvedError
from physident.estimation.estimators import HUBER, Physical
from physident.estimation.least_squares import solve_step
from physident.estimation.physical.bootstrap import bootstrap_covariance
from physident.estimation.physical.certificate import Certificate, condition_number
from physident.estimation.physical.cones import Cones, physical_cones
from physident.estimation.physical.coordinates import Coordinates
from physident.estimation.physical.information_shares import InformationShares, information_shares
from physident.estimation.physical.prior import nominal_values
from physident.estimation.physical.prior_weight import choose_prior_weight
from physident.estimation.physical.problem import Answer, PhysicalProblem
from physident.estimation.physical.semidefinite_program import SemidefiniteProgram
from physident.estimation.robust import huber_weights, middle_sigma
from physident.estimation.uncertainty import correlation_rows, jackknife
from physident.estimation.weighting import Compressed, compress, expand, joint_sigma, noise_floor, weight_rows
from physident.identifiability.base_parameters import BaseParameters
from physident.robots.robot import Robot

Array = NDArray[np.float64]
MAX_ITERATIONS = 60
SETTLED = 1e-3  # relative change of the noise between iterations: a hundredth of what its own estimate is worth
MEMORY_ITERATIONS = 3  # in which the residual's autocorrelation is measured anew
FIRST_NOISE = 100.0  # times the smallest noise of a joint, at the start
MIN_MULTIPLIER = 1e-7  # of an active constraint


@dataclass(frozen=True, eq=False, kw_only=True)
class PhysicalSolution:
    """Parameters ``theta`` (p,), their uncertainty, and their proof.

    ``covariance`` (r, r) of the base parameters from ``blocks`` blocks; ``sigma`` (n,) [N m|N] of the residual,
    ``effective_samples`` (n,); the ``prior_weight`` used; ``shares`` of the information that came from the data;
    ``active_constraints`` in words.
    """

    theta: Array
    covariance: Array
    sigma: Array
    effective_samples: Array
    blocks: int
    prior_weight: float
    shares: InformationShares
    certificate: Certificate
    active_constraints: tuple[str, ...]


def solve_physical(
    regressor: Regressor,
    base: BaseParameters,
    robot: Robot,
    effects: Sequence[Effect],
    nominal: Array,
    settings: Physical,
) -> PhysicalSolution:
    """The physical estimate of a regressor, with a prior around the parameters ``nominal`` (p,).

    The data term is the squared residual over the noise, scaled to the number of independent samples it amounts to, so
    that a prior weight means the same for short and for long recordings. Raises InputError for a prior that does not fit
    the model, NotSolvedError for contradictory constraints or an answer that cannot be proved.
    """
    nominal = nominal_values(settings.prior, base.columns, nominal)
    cones = physical_cones(robot, effects, settings.total_mass, settings.bounding_volumes, settings.bounds)
    try:
        scaled = Coordinates.around(nominal, base.columns, _torque_sizes(regressor))
        return _solve_in(scaled, regressor, base, nominal, cones, settings)
    except NotSolvedError:  # either scaling can defeat the solver; the answer is proved in the same way in both
        return _solve_in(Coordinates.around(nominal, base.columns), regressor, base, nominal, cones, settings)


def _solve_in(
    coordinates: Coordinates,
    regressor: Regressor,
    base: BaseParameters,
    nominal: Array,
    cones: Cones,
    settings: Physical,
) -> PhysicalSolution:
    """The physical estimate, solved in some coordinates."""
    program = SemidefiniteProgram(PhysicalProblem(base.grouping, coordinates, cones, settings.prior))
    sigma = _first_sigma(regressor, base, nominal)
    weight = 1.0 if settings.prior.weight == "auto" else float(settings.prior.weight)
    fit = _settle(program, regressor, base, sigma, weight, settings)
    if settings.prior.weight == "auto":
        white = weight_rows(regressor, 1 / fit.sigma)
        weight = choose_prior_weight(program, white, base, float(np.mean(1 / fit.memory)))
        fit = _settle(program, regressor, base, fit.sigma, weight, settings)
    covariance, blocks, shares = _uncertainty(program, regressor, base, fit, settings)
    theta = coordinates.T @ fit.answer.u
    return PhysicalSolution(
        theta=theta,
        covariance=covariance,
        sigma=fit.sigma,
        effective_samples=len(regressor.torque) / fit.memory,
        blocks=blocks,
        prior_weight=weight,
        shares=shares,
        certificate=_certificate(fit, theta, cones, shares),
        active_constraints=_active_constraints(cones, fit.answer),
    )


def _torque_sizes(regressor: Regressor) -> Array:
    """RMS torque (p,) [N m|N] that a unit of each parameter causes on the joint where it causes most."""
    sizes = np.zeros(len(regressor.columns))
    for joint in regressor.joints:
        np.maximum.at(sizes, joint.columns, np.sqrt(np.mean(joint.values**2, axis=0)))
    return sizes


def _first_sigma(regressor: Regressor, base: BaseParameters, nominal: Array) -> Array:
    """Where the iteration over the noise starts: ordinary least squares, which alone overfits short data."""
    x = solve_step(regressor, base, None, base.values(nominal)).x
    residual = regressor.residual(expand(base, x))
    return np.maximum(joint_sigma(regressor, residual, 0.0), FIRST_NOISE * noise_floor(regressor))


@dataclass(frozen=True, eq=False)
class _Fit:
    """A settled fit: its answer and data, the noise (n,) [N m|N] and the residuals' memory (n,) [rows]."""

    answer: Answer
    data: Compressed
    sigma: Array
    memory: Array
    iterations: int


def _settle(
    program: SemidefiniteProgram,
    regressor: Regressor,
    base: BaseParameters,
    sigma: Array,
    weight: float,
    settings: Physical,
) -> _Fit:
    """Iterates the size of the noise (and the weights of a robust loss) with the fit until it settles."""
    rows, memory, theta = np.ones(regressor.torque.shape), None, None
    floor = noise_floor(regressor)
    for iteration in range(1, MAX_ITERATIONS + 1):
        robust = settings.loss == "huber" and theta is not None
        data = compress(weight_rows(regressor, rows / sigma), base) if robust else compress(regressor, base, 1 / sigma)
        independent_share = 1.0 if memory is None else float(np.mean(1 / memory))
        answer = program.solve(data, weight / (independent_share * data.rows))
        theta = program.problem.coordinates.T @ answer.u
        residual = regressor.residual(theta)
        if settings.loss == "huber":
            found = middle_sigma(regressor, residual)
            rows = np.sqrt(huber_weights(residual / found, HUBER))
        else:
            found = joint_sigma(regressor, residual, 0.0)
        found = np.maximum(found, floor)
        settled = memory is not None and np.allclose(found, sigma, rtol=SETTLED)
        if memory is None or iteration <= MEMORY_ITERATIONS:  # its sum is cut off at a lag that may alternate for ever
            memory = correlation_rows(regressor, residual)
        if settled:
            return _Fit(answer, data, sigma, memory, iteration)
        sigma = found
    raise NotSolvedError(
        f"the noise did not settle with the physical fit in {MAX_ITERATIONS} iterations; try a prior weight ten times larger"
    )


def _uncertainty(
    program: SemidefiniteProgram, regressor: Regressor, base: BaseParameters, fit: _Fit, settings: Physical
) -> tuple[Array, int, InformationShares]:
    """Covariance (r, r) of the base parameters, the number of blocks behind it, and the shares of the information."""
    white = weight_rows(regressor, 1 / fit.sigma)
    residual = white.residual(program.problem.coordinates.T @ fit.answer.u)
    bend = HUBER if settings.loss == "huber" else np.inf
    inside = (np.abs(residual) <= bend).astype(float)
    curved = compress(weight_rows(white, inside), base) if settings.loss == "huber" else fit.data
    shares = information_shares(program.problem, curved, fit.answer)
    influence = np.clip(residual, -bend, bend)
    left_out = jackknife(white, base, influence, float(fit.memory.max()), inside, shares.information)
    if settings.resamples:
        covariance = bootstrap_covariance(
            program, fit.data, curved, fit.answer, left_out, settings.resamples, settings.seed
        )
    else:
        shifts = left_out.pushes @ shares.response.T
        covariance = shifts.T @ shifts * left_out.shrink
    return covariance, left_out.informative, shares


def _certificate(fit: _Fit, theta: Array, cones: Cones, shares: InformationShares) -> Certificate:
    optimality = fit.answer.optimality
    eigenvalues = [np.linalg.eigvalsh(matrix.at(theta)) for matrix in cones.matrices]
    lengths = np.maximum(np.linalg.norm(fit.data.R, axis=0), 1e-300)
    singular = np.linalg.svd(fit.data.R / lengths, compute_uv=False)
    return Certificate(
        stationarity=optimality.dual,
        condition=condition_number(singular),
        determined=shares.base_by_data,
        iterations=fit.iterations,
        primal=optimality.primal,
        gap=optimality.gap,
        eigenvalues=tuple(float(v[0] / v[-1]) for v in eigenvalues),
    )


def _active_constraints(cones: Cones, answer: Answer) -> tuple[str, ...]:
    """The inequalities that the data push against, in words."""
    y = answer.multipliers.rows
    labels = [label for label, value in zip(cones.labels, y, strict=False) if value > MIN_MULTIPLIER]
    return tuple(dict.fromkeys(labels))
