"""The physically consistent estimate: noise, loss and prior weight around the convex program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor
from physident.effects.effect import Effect
from physident.errors import InputError, NotSolvedError
from physident.estimation.estimators import HUBER, Physical
from physident.estimation.least_squares import solve_step
from physident.estimation.physical.certificate import Certificate
from physident.estimation.physical.cones import Cones, physical_cones
from physident.estimation.physical.coordinates import Coordinates
from physident.estimation.physical.decision import Decision, decide
from physident.estimation.physical.prior import nominal_values
from physident.estimation.physical.program import Answer, Program
from physident.estimation.robust import huber_weights, middle_sigma
from physident.estimation.uncertainty import Jackknife, block_labels, correlation_rows, jackknife
from physident.estimation.weighting import Compressed, compress, expand, joint_sigma, weight_rows
from physident.identifiability.base_parameters import BaseParameters
from physident.robots.robot import Robot

Array = NDArray[np.float64]
MAX_ITERATIONS = 60
SETTLED = 1e-3  # relative change of the noise between iterations: a hundredth of what its own estimate is worth
WEIGHTS = tuple(float(w) for w in 10.0 ** np.arange(-2, 5))  # tried by "auto"
FOLDS = 8
MEMORY_ITERATIONS = 3
LEAST_NOISE = 0.01  # of a joint's torque, at the start
DIGITS = 1e-4  # of a joint's torque: no torque is known better, and a solver could not use it


@dataclass(frozen=True, eq=False)
class PhysicalSolution:
    """Parameters theta (p,), what is known about them, and their proof.

    ``covariance`` (r, r) of the base parameters from ``blocks`` blocks; ``sigma``, ``effective_samples`` (n,);
    ``prior_weight`` used; ``decision`` what the data decided; ``held`` the cones the answer rests on, in words.
    """

    theta: Array
    covariance: Array
    sigma: Array
    effective_samples: Array
    blocks: int
    prior_weight: float
    decision: Decision
    certificate: Certificate
    held: tuple[str, ...]


def solve_physical(
    regressor: Regressor, base: BaseParameters, robot: Robot, effects: Sequence[Effect], nominal: Array, how: Physical
) -> PhysicalSolution:
    """The physical estimate of a regressor; raises InputError for a prior that does not fit, NotSolvedError for
    constraints that contradict or an answer that cannot be proved.

    The data term is the residuals' squares over the noise, scaled to the number of independent samples they are worth,
    so that a prior weight means the same for short and for long recordings.
    """
    nominal = nominal_values(how.prior, base.columns, nominal)
    cones = physical_cones(robot, effects, how.total_mass, how.shapes, how.bounds)
    try:
        scaled = Coordinates.around(nominal, base.columns, _sizes(regressor))
        return _solved(regressor, base, nominal, cones, scaled, how)
    except NotSolvedError:  # each scale has data on which the solver stumbles; an answer is proved the same in both
        return _solved(regressor, base, nominal, cones, Coordinates.around(nominal, base.columns), how)


def _solved(
    regressor: Regressor, base: BaseParameters, nominal: Array, cones: Cones, coordinates: Coordinates, how: Physical
) -> PhysicalSolution:
    """The physical estimate, solved in some coordinates."""
    program = Program(base.grouping, coordinates, cones, how.prior)
    sigma = _first_sigma(regressor, base, nominal)
    weight = 1.0 if how.prior.weight == "auto" else float(how.prior.weight)
    fit = _settle(program, regressor, base, sigma, weight, how)
    if how.prior.weight == "auto":
        weight = _left_out_weight(program, weight_rows(regressor, 1 / fit.sigma), fit, base)
        fit = _settle(program, regressor, base, fit.sigma, weight, how)
    white = weight_rows(regressor, 1 / fit.sigma)
    residual = white.torque - white.predict(program.coordinates.T @ fit.answer.u)
    bend = HUBER if how.loss == "huber" else np.inf
    inside = (np.abs(residual) <= bend).astype(float)
    curved = compress(weight_rows(white, inside), base) if how.loss == "huber" else fit.data
    decision = decide(program, curved, fit.answer)
    influence = np.clip(residual, -bend, bend)
    left_out = jackknife(white, base, influence, float(fit.memory.max()), inside, decision.information)
    if how.resamples == 0:
        moved = left_out.pushes @ decision.response.T
        covariance = moved.T @ moved * left_out.shrink
    else:
        covariance = _bootstrap(program, curved, fit, left_out, how)
    theta, optimality = coordinates.T @ fit.answer.u, fit.answer.optimality
    eigenvalues = [np.linalg.eigvalsh(m.at(theta)) for m in cones.matrices]
    singular = np.linalg.svd(fit.data.R / np.maximum(np.linalg.norm(fit.data.R, axis=0), 1e-300), compute_uv=False)
    certificate = Certificate(
        optimality.dual, float(singular[0] / max(singular[-1], 1e-300)), decision.base_by_data, fit.iterations,
        optimality.primal, optimality.gap, tuple(float(v[0] / v[-1]) for v in eigenvalues),
    )  # fmt: skip
    return PhysicalSolution(
        theta, covariance, fit.sigma, len(regressor.torque) / fit.memory, left_out.blocks,
        weight, decision, certificate, _held(cones, fit.answer),
    )  # fmt: skip


def _sizes(regressor: Regressor) -> Array:
    """Torque (p,) [N m|N] that a unit of each parameter makes on the joint that shows it most, RMS."""
    sizes = np.zeros(len(regressor.columns))
    for joint in regressor.joints:
        np.maximum.at(sizes, joint.columns, np.sqrt(np.mean(joint.values**2, axis=0)))
    return sizes


def _first_sigma(regressor: Regressor, base: BaseParameters, nominal: Array) -> Array:
    """Where the noise's iteration starts: plain least squares, which fits short data too well to be believed alone."""
    x = solve_step(regressor, base, None, base.values(nominal)).x
    residual = regressor.torque - regressor.predict(expand(base, x))
    return np.maximum(joint_sigma(regressor, residual, 0.0), LEAST_NOISE * np.sqrt((regressor.torque**2).mean(axis=0)))


@dataclass(frozen=True, eq=False)
class _Fit:
    """A settled fit: its answer and data, the noise (n,), residuals' memory (n,) [rows]."""

    answer: Answer
    data: Compressed
    sigma: Array
    memory: Array
    strength: float
    iterations: int


def _settle(
    program: Program, regressor: Regressor, base: BaseParameters, sigma: Array, weight: float, how: Physical
) -> _Fit:
    """Iterates the noise's size (and a robust loss's weights) with the fit until it settles."""
    rows, memory, theta = np.ones(regressor.torque.shape), None, None
    for iteration in range(1, MAX_ITERATIONS + 1):
        robust = how.loss == "huber" and theta is not None
        data = compress(weight_rows(regressor, rows / sigma), base) if robust else compress(regressor, base, 1 / sigma)
        worth = 1.0 if memory is None else float(np.mean(1 / memory))
        strength = weight / (worth * data.rows)
        answer = program.solve(data, strength)
        theta = program.coordinates.T @ answer.u
        residual = regressor.torque - regressor.predict(theta)
        if how.loss == "huber":
            found = middle_sigma(regressor, residual)
            rows = np.sqrt(huber_weights(residual / found, HUBER))
        else:
            found = joint_sigma(regressor, residual, 0.0)
        found = np.maximum(found, DIGITS * np.sqrt((regressor.torque**2).mean(axis=0)))
        settled = memory is not None and np.allclose(found, sigma, rtol=SETTLED)
        if memory is None or iteration <= MEMORY_ITERATIONS:  # a sum cut off at a lag may flip for ever: then held
            memory = correlation_rows(regressor, residual)
        if settled:
            return _Fit(answer, data, sigma, memory, strength, iteration)
        sigma = found
    raise NotSolvedError(
        f"the noise did not settle with the physical fit in {MAX_ITERATIONS} iterations; try a prior weight ten times larger"
    )


def _bootstrap(program: Program, curved: Compressed, fit: _Fit, left_out: Jackknife, how: Physical) -> Array:
    """Covariance (r, r) of the base parameters over refits to resampled blocks.

    Wild block bootstrap: each block's gradient keeps its size and gets a random sign, the motion stays (Cameron,
    Gelbach, Miller, "Bootstrap-based improvements for inference with clustered errors", 2008).
    """
    b = program.KT @ fit.answer.u
    settled = fit.data.R.T @ (fit.data.z - fit.data.R @ b)  # the gradient that prior and cones hold at the answer
    to_z = np.linalg.pinv(curved.R.T, rcond=1e-10)
    rng = np.random.default_rng(how.seed)
    values = []
    for signs in rng.choice([-1.0, 1.0], size=(how.resamples, left_out.blocks)):
        push = signs @ left_out.pushes * np.sqrt(left_out.shrink)
        other = Compressed(curved.R, curved.R @ b + to_z @ (settled + push), fit.data.rest, fit.data.rows)
        values.append(program.KT @ program.solve(other, fit.strength).u - b)
    return np.atleast_2d(np.cov(np.array(values).T, ddof=1))


def _left_out_weight(program: Program, white: Regressor, fit: _Fit, base: BaseParameters) -> float:
    """The prior weight whose fits predict left-out recordings best; blocks where there is only one recording."""
    labels = white.recording
    if len(np.unique(labels)) == 1:
        labels = block_labels(white.segment, max(1, -(-len(labels) // 4)))
    names = np.unique(labels)
    if len(names) < 2:
        raise InputError(
            "prior weight 'auto' needs data to leave out: give two recordings, or a longer one, or a weight"
        )
    folds = [np.flatnonzero(np.isin(labels, part)) for part in np.array_split(names, min(FOLDS, len(names)))]
    parts = [(_select(white, np.setdiff1d(np.arange(len(labels)), rows)), _select(white, rows)) for rows in folds]
    data = [(compress(train, base), test) for train, test in parts]
    worth = float(np.mean(1 / fit.memory))
    errors = []
    for weight in WEIGHTS:
        error = 0.0
        for train, test in data:
            theta = program.coordinates.T @ program.solve(train, weight / (worth * train.rows)).u
            error += float(((test.torque - test.predict(theta)) ** 2).sum())
        errors.append(error)
    return WEIGHTS[int(np.argmin(errors))]


def _select(regressor: Regressor, rows: NDArray[np.intp]) -> Regressor:
    joints = tuple(replace(joint, values=joint.values[rows]) for joint in regressor.joints)
    return replace(
        regressor, joints=joints, torque=regressor.torque[rows], time=regressor.time[rows],
        recording=regressor.recording[rows], segment=regressor.segment[rows], counted=regressor.counted[rows],
    )  # fmt: skip


def _held(cones: Cones, answer: Answer) -> tuple[str, ...]:
    """The inequalities that the data push against, in words."""
    y = answer.multipliers.rows
    pushed = [label for label, value in zip(cones.labels, y, strict=False) if value > 1e-7]
    return tuple(dict.fromkeys(pushed))
