"""The load an arm carries: ten parameters, identified with the arm's own parameters fixed."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor
from physident.effects.inertia import RigidBody
from physident.errors import InputError, NotSolvedError, warn
from physident.estimation.dry_friction.row_weights import dry_level, known_rows, rest_weights, spread_rows
from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.estimation.least_squares import Solution, least_squares, solve_step
from physident.estimation.payload.friction_of_the_day import refit_friction
from physident.estimation.payload.gain_change import find_gain_change
from physident.estimation.payload.load_regressor import all_independent, load_regressor, solid_load
from physident.estimation.payload.payload import Payload
from physident.estimation.physical.cones import Cones, MatrixInequality
from physident.estimation.uncertainty import BLOCK_PERIODS, FEWEST_BLOCKS, block_labels, correlation_rows, t_quantile
from physident.estimation.weighting import Compressed, compress, weight_rows
from physident.identifiability.base_parameters import random_motion
from physident.large_arrays import blocks
from physident.recordings.checks import refuse_duplicates
from physident.recordings.load import Recordings, as_recordings
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter, Signals
from physident.robots.inertia import PARAMETER_NAMES, about_centre, pseudo_inertia
from physident.setup_checks.check_setup import warn_of_setup
from physident.threads import one_thread

Array = NDArray[np.float64]
DRAWS = 200  # draws behind the intervals: their ends then vary by a tenth of a standard error
MIN_SOLVED = 0.95  # share of the draws that must be solved
MAX_ROUNDS = 50
LARGEST = 1e6  # kg, kg m, kg m^2: rounds that reach it do not settle
SETTLED = 1e-6  # change of the load from one round to the next
UNSHOWN = 1e-6  # of the best shown direction: rounding
MIN_TORQUE = 0.25  # a joint whose load torque is a smaller share of its residual is not evaluated alone


@one_thread
def identify_payload(estimate: Estimate, recordings: Recordings, seed: int = 0) -> Payload:
    """The load on the last link that explains the residual of the arm's model in recordings.

    The arm's parameters are those of ``estimate``; the load is a rigid body (pseudo-inertia positive semidefinite). The
    intervals account for the residual's autocorrelation, the uncertainty of the arm's parameters, and the cone; ``seed``
    draws them. Raises InputError for training recordings of the arm's model, recordings that do not fit the robot, efforts
    that cannot be the arm's, or a motion that does not show all ten parameters; NotSolvedError where no optimum can be
    proved.
    """
    model = estimate.model
    recordings = as_recordings(recordings, model.robot, estimate.layout)
    _refuse_fitted(estimate, recordings)
    if not any(effect.name == "rigid_body" for effect in model.effects):
        raise InputError(
            "the model has no rigid_body effect, so no link that could carry a load; identify one with it in --effects"
        )
    warn_of_setup(None, recordings)
    converted = [recording.with_default_drive_gains(estimate.drive_gains) for recording in recordings]
    signals = prepare_all(model.robot, converted, estimate.filter)
    whole, load, free = _free_load(estimate, signals)
    arm = _arm_covariance(estimate, whole, load, free.sigma)
    covariance = free.covariance + arm
    parameters, draws = _on_cone(load, free, covariance, seed)
    centres = draws[:, 1:4] / draws[:, :1]
    return Payload(
        parameters=parameters,
        intervals=_middle(draws),
        mass_interval=_middle(draws[:, :1])[0],
        centre_interval=_middle(centres),
        moment_interval=_middle(np.array([np.diag(about_centre(one)[1]) for one in draws])),
        seen_by_joint=_seen_by_joint(load, parameters, free.sigma),
        sigma=np.sqrt((load.residual(parameters) ** 2).mean(axis=0)),
        sigma_without_load=np.sqrt((load.torque**2).mean(axis=0)),
        arm_sigma=np.array(estimate.sigma),
        visible=bool(free.base[0] > t_quantile(free.blocks) * np.sqrt(covariance[0, 0])),
        scale=_scale(converted),
        gain_change=find_gain_change(estimate, whole, load, free.sigma),
        friction_of_the_day=refit_friction(model, whole, load, free.sigma),
        recordings=tuple(recording.source for recording in recordings),
    )


def _free_load(estimate: Estimate, signals: Sequence[Signals]) -> tuple[Regressor, Regressor, Solution]:
    """The arm's regressor, the load's, and the load without a cone.

    Effects that depend on the torque a joint carries are evaluated with the load on the arm, until it settles.
    """
    model, parameters = estimate.model, np.zeros(10)
    model_dependent = [effect.name for effect in model.effects if effect.needs_model]
    for _ in range(MAX_ROUNDS):
        if not np.abs(parameters).max() < LARGEST:
            break
        whole = build_regressor(
            model.robot, model.effects, signals, estimate.filter, model=_carrying(model, parameters)
        )
        with warnings.catch_warnings(record=True) as caught:  # only those of the last round are passed on
            whole, load = _weighted(model, whole, signals, estimate.filter)
            free = least_squares(load, all_independent(load.columns), np.zeros(10), "diagonal")
        if np.linalg.norm(free.base - parameters) <= SETTLED * np.linalg.norm(free.base) or not model_dependent:
            _refuse_hidden(free, model)
            for warning in caught:
                warn(str(warning.message))
            return whole, load, free
        parameters = free.base
    raise NotSolvedError(
        f"the load and the effects that depend on it did not settle in {MAX_ROUNDS} rounds; identify the arm without {', '.join(model_dependent)}"
    )


def _weighted(
    model: Model, whole: Regressor, signals: Sequence[Signals], filter: Filter
) -> tuple[Regressor, Regressor]:
    """The arm's regressor and the load's with the row weights that the arm was identified with: near standstill, the sign of
    dry friction is not known."""
    spread = spread_rows(model.robot, model.effects, signals, filter)

    def weighted(weights: Array) -> tuple[Regressor, Regressor]:
        rows = weight_rows(whole, weights)
        return rows, load_regressor(rows, rows.residual(model.theta))

    _, known = weighted(known_rows(spread))
    base = all_independent(known.columns)
    first = solve_step(known, base, None, np.zeros(10)).x
    _, load = weighted(np.ones_like(spread))
    residual = load.residual(first)
    return weighted(rest_weights(spread, dry_level(model), residual, whole))


def _carrying(model: Model, load: Array) -> Model:
    """The model with ten parameters added to its last link."""
    theta = np.array(model.theta)
    theta[[i for i, c in enumerate(model.columns) if c.effect == "rigid_body" and c.joint == model.robot.n]] += load
    return replace(model, theta=theta)


def _refuse_fitted(estimate: Estimate, recordings: Sequence[Recording]) -> None:
    if not recordings:
        raise InputError("no recordings given, expected at least one with the load on the arm")
    fitted = {source.sha256 for source in estimate.sources}
    refuse_duplicates(recordings)
    for recording in recordings:
        if recording.sha256 in fitted:
            raise InputError(
                f"{recording.source}: is a training recording of the arm's model, which contains its load already; expected another recording with the load"
            )


def _refuse_hidden(free: Solution, model: Model) -> None:
    hidden = [name for name, seen in zip(PARAMETER_NAMES, free.determined, strict=True) if not seen]
    if hidden and any(name in hidden for name in _shown_by_no_motion(model)):
        raise InputError(
            f"no motion of this arm shows {', '.join(hidden)} of a load on its own; physident diagnose tells what it shows of the load (payload)"
        )
    if hidden:
        raise InputError(
            f"the motion does not show {', '.join(hidden)} of the load on its own; expected motion of every joint that turns the load about three axes"
        )


def _shown_by_no_motion(model: Model) -> list[str]:
    """The parameters of a load that the arm's joints cannot tell from others: of a SCARA's quill, most moments of inertia."""
    columns = RigidBody().regressor(model.robot, model.refer(random_motion(model.robot, 0)))[:, :, -10:].reshape(-1, 10)
    _, sizes, directions = np.linalg.svd(
        columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-12), full_matrices=True
    )
    hidden = np.abs(directions[sizes < UNSHOWN * sizes[0]]).max(axis=0, initial=0.0) > UNSHOWN
    return [name for name, never in zip(PARAMETER_NAMES, hidden, strict=True) if never]


def _arm_covariance(estimate: Estimate, whole: Regressor, load: Regressor, sigma: Array) -> Array:
    """Covariance (10, 10) of the load's parameters due to the arm's: the load explains the arm's errors."""
    normal, mixed = np.zeros((10, 10)), np.zeros((10, estimate.base.r))
    place = np.full(len(whole.columns), -1)
    place[estimate.base.independent] = np.arange(estimate.base.r)
    for arm, carried, s in zip(whole.joints, load.joints, sigma, strict=True):
        seen = place[arm.columns] >= 0
        for some in blocks(len(load.time)):
            A, Y = carried.some(some) / s, arm.some(some)[:, seen] / s
            normal[np.ix_(carried.columns, carried.columns)] += A.T @ A
            mixed[np.ix_(carried.columns, place[arm.columns[seen]])] += A.T @ Y
    transfer = np.linalg.solve(normal, mixed)
    return transfer @ estimate.covariance @ transfer.T


def _on_cone(load: Regressor, free: Solution, covariance: Array, seed: int) -> tuple[Array, Array]:
    """The most likely rigid body, and those of draws around the free estimate: Student's t, as there are few blocks."""
    from physident.estimation.physical.coordinates import Coordinates
    from physident.estimation.physical.prior import NoPrior
    from physident.estimation.physical.problem import PhysicalProblem
    from physident.estimation.physical.semidefinite_program import SemidefiniteProgram  # cvxpy takes a second to import

    base = all_independent(load.columns)
    data = compress(load, base, 1 / free.sigma)
    body = MatrixInequality(
        np.stack([pseudo_inertia(unit) for unit in np.eye(10)], axis=-1),
        np.zeros((4, 4)),
        "the load is not a rigid body",
        load.columns[0].joint,
    )
    none = np.zeros((0, 10))
    cones = Cones(rows=none, offsets=np.zeros(0), matrices=(body,), equal=none, targets=np.zeros(0), labels=())
    coordinates = Coordinates.around(solid_load(free.base[0], free.base[1:4]), load.columns)
    program = SemidefiniteProgram(PhysicalProblem(np.eye(10), coordinates, cones, NoPrior()))
    rng = np.random.default_rng(seed)
    freedom = max(1, free.blocks - 1)
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    steps = rng.standard_normal((DRAWS, 10)) / np.sqrt(rng.chisquare(freedom, size=(DRAWS, 1)) / freedom)
    draws = []
    for x in free.base + steps @ root.T:
        with suppress(NotSolvedError):  # a far outlier may defeat the solver; a few of them change no quantile
            draws.append(program.solve(Compressed(data.R, data.R @ x, data.rest, data.rows), 0.0).u)
    if len(draws) < MIN_SOLVED * DRAWS:
        raise NotSolvedError(
            f"{DRAWS - len(draws)} of {DRAWS} draws behind the load's intervals were not solved; record the load for longer"
        )
    best = program.solve(data, 0.0).u
    return coordinates.T @ best, np.array(draws) @ coordinates.T.T


def _middle(draws: Array) -> Array:
    """The middle 95 % (k, 2) of draws (D, k)."""
    return np.quantile(draws, (0.025, 0.975), axis=0).T


def _seen_by_joint(load: Regressor, parameters: Array, sigma: Array) -> Array:
    """Mass (n,) [kg] and its standard error by each joint alone, all other ratios fixed: joints differ where gains do."""
    predicted = load.predict(parameters)
    residual = load.torque - predicted
    length = math.ceil(BLOCK_PERIODS * correlation_rows(load, residual).max())
    labels = block_labels(load.segment, max(1, min(length, len(residual) // FEWEST_BLOCKS)))
    few = math.sqrt((labels[-1] + 1) / labels[-1])
    seen = np.full((predicted.shape[1], 2), np.nan)
    for j, (p, r) in enumerate(zip(predicted.T, load.torque.T, strict=True)):
        if np.sqrt((p**2).mean()) < MIN_TORQUE * sigma[j]:
            continue
        ratio = float(p @ r) / float(p @ p)
        scores = np.bincount(labels, weights=p * (r - ratio * p))
        seen[j] = parameters[0] * ratio, few * parameters[0] * np.linalg.norm(scores) / float(p @ p)
    return seen


def _scale(recordings: Sequence[Recording]) -> str:
    if all(recording.effort_kind == "torque" for recording in recordings):
        return "the mass is as accurate as the scale of the measured torque"
    return (
        "mass and torque scale are confounded: torque is current times drive gains, and gains that are all 5 % too high"
        " make the load 5 % too heavy; a load of known mass separates them (physident drive-gains)"
    )
