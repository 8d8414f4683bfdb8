"""The estimate of a regressor that is already built, its rests held where friction is exhausted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor
from physident.effects.effect import Effect
from physident.estimation.dry_friction.held_rests import hold_rests, same_sides, settle_rests, with_dry_columns
from physident.estimation.dry_friction.rest import rest_rows
from physident.estimation.dry_friction.row_weights import row_weights
from physident.estimation.estimate import Estimate
from physident.estimation.estimated_model import Source
from physident.estimation.estimators import OLS, WLS, Estimator, Physical, Robust, make_estimator
from physident.estimation.least_squares import Solution, least_squares
from physident.estimation.physical.certificate import Certificate
from physident.estimation.physical.cones import physical_cones
from physident.estimation.robust import robust_least_squares
from physident.estimation.shapes.curve_priors import with_amplitudes, with_prior
from physident.estimation.sizing import unsized_parameters
from physident.estimation.weighting import information_in, weight_rows
from physident.identifiability.base_parameters import BaseParameters, find_base_parameters
from physident.large_arrays import squares
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
SIDES = 3  # times that an estimator may choose the sides of rests anew: others lie at their band's edge


def fit_with_rests(
    robot: Robot,
    effects: tuple[Effect, ...],
    regressor: Regressor,
    signals: Sequence[Signals],
    recordings: Sequence[Recording],
    estimator: Estimator,
    filter: Filter,
    columns: str | None = None,
) -> tuple[Estimate, Regressor, Sequence[Signals]]:
    """The estimate of a regressor whose rests are held where friction is exhausted, with the weighted rows and the signals of that;
    ordinary least squares takes all rows alike."""
    plain, asked = isinstance(estimator, OLS), (regressor, signals)
    if not plain:
        signals, regressor = settle_rests(robot, effects, regressor, signals, filter)

    def counted() -> Regressor:
        return regressor if plain else weight_rows(regressor, row_weights(robot, effects, regressor, signals, filter))

    effects, sides = with_amplitudes(robot, effects, counted()), 0
    while True:
        rows = counted()
        estimate = estimate_from(robot, effects, rows, recordings, estimator, filter, columns)
        sides += 1
        if plain or sides == SIDES:
            break
        held = hold_rests(estimate.model, signals)
        if same_sides(signals, held):
            break
        signals, regressor = held, with_dry_columns(estimate.model, regressor, held, filter)
    return replace(estimate, relative=_of_all_rows(estimate.model, *asked, filter)), rows, signals


def _of_all_rows(model: Model, regressor: Regressor, signals: Sequence[Signals], filter: Filter) -> Array:
    """What the model leaves (n,) [%] of all rows, the mean over the recordings, as ``validate`` scores it: rows of an uncertain sign count for
    less when parameters are fitted, and not when a model is judged."""
    left = regressor.residual(model.theta) - rest_rows(model, signals, filter).friction * regressor.counted
    shares = []
    for index in range(len(signals)):
        rows = slice(*np.searchsorted(regressor.recording, (index, index + 1)))
        size = np.sqrt(squares(regressor.torque[rows]))
        shares.append(100 * np.sqrt(squares(left[rows])) / np.where(size > 0, size, 1.0))
    return np.mean(shares, axis=0)


def estimate_from(
    robot: Robot,
    effects: tuple[Effect, ...],
    regressor: Regressor,
    recordings: Sequence[Recording],
    method: str | Estimator,
    filter: Filter,
    columns: str | None = None,
) -> Estimate:
    """The estimate of a regressor that is already built, whose relative error is that of its rows as they are weighted."""
    estimator = make_estimator(method)
    regressor = with_prior(robot, effects, regressor)
    base = find_base_parameters(robot, effects)
    nominal = Model.nominal(robot, effects).theta
    sources = tuple(_source(i, recording, regressor) for i, recording in enumerate(recordings))
    if isinstance(estimator, Physical):
        from physident.estimation.physical.physical_fit import solve_physical  # cvxpy takes a second to import

        physical = solve_physical(regressor, base, robot, effects, nominal, estimator)
        return Estimate(
            model=Model(robot, effects, physical.theta),
            estimator=estimator,
            covariance=physical.covariance,
            information=information_in(regressor, base, physical.sigma, physical.effective_samples),
            sigma=physical.sigma,
            relative=_relative(regressor, physical.theta),
            effective_samples=physical.effective_samples,
            certificate=physical.certificate,
            filter=filter,
            sources=sources,
            fitted=tuple(recordings),
            layout=columns,
            drive_gains=shared_gains(recordings),
            blocks=physical.blocks,
            prior_weight=physical.prior_weight,
            shares=tuple(float(share) for share in physical.shares.directions),
            base_shares=tuple(float(share) for share in physical.shares.base),
            active_constraints=physical.active_constraints,
            unsized=unsized_parameters(regressor, base, physical.theta),
        )
    solution = _least_squares_solution(regressor, base, nominal, estimator)
    theta = base.nearest(nominal, solution.base)
    matrices = physical_cones(robot, effects).matrices
    return Estimate(
        model=Model(robot, effects, theta),
        estimator=estimator,
        covariance=solution.covariance,
        information=information_in(regressor, base, solution.sigma, solution.effective_samples),
        sigma=solution.sigma,
        relative=_relative(regressor, theta),
        effective_samples=solution.effective_samples,
        certificate=Certificate(
            stationarity=solution.stationarity,
            condition=solution.condition,
            determined=int(solution.determined.sum()),
            iterations=solution.iterations,
            eigenvalues=tuple(smallest_share(matrix.at(theta)) for matrix in matrices),
        ),
        filter=filter,
        sources=sources,
        fitted=tuple(recordings),
        layout=columns,
        drive_gains=shared_gains(recordings),
        blocks=solution.blocks,
        base_shares=tuple(float(determined) for determined in solution.determined),
        unsized=unsized_parameters(regressor, base, theta),
    )


def _least_squares_solution(
    regressor: Regressor, base: BaseParameters, nominal: Array, estimator: OLS | WLS | Robust
) -> Solution:
    if isinstance(estimator, Robust):
        return robust_least_squares(regressor, base, nominal, estimator.threshold)
    return least_squares(regressor, base, nominal, estimator.noise if isinstance(estimator, WLS) else "equal")


def smallest_share(P: Array) -> float:
    """Smallest eigenvalue of a symmetric matrix over its largest in size; zero for a zero matrix."""
    values = np.linalg.eigvalsh(P)
    return float(values[0]) / size if (size := float(np.abs(values).max())) > 0 else 0.0


def _relative(regressor: Regressor, theta: Array) -> Array:
    size = np.sqrt(squares(regressor.torque))
    return 100 * np.sqrt(squares(regressor.residual(theta))) / np.where(size > 0, size, 1.0)


def _source(index: int, recording: Recording, regressor: Regressor) -> Source:
    used = np.count_nonzero(regressor.recording == index) / regressor.kept_rate
    return Source(recording.source, recording.sha256, recording.duration, float(used))


def shared_layout(recordings: Sequence[Recording]) -> str | None:
    """The text that declared the columns of the recordings' files, None where there is none or they differ."""
    layouts = {recording.layout for recording in recordings}
    return layouts.pop() if len(layouts) == 1 else None


def shared_gains(recordings: Sequence[Recording]) -> tuple[float, ...] | None:
    """The drive gains (n,) [N m/A] of recordings of current, None where they have none or differ."""
    gains = {recording.drive_gains for recording in recordings if recording.effort_kind == "current"}
    return gains.pop() if len(gains) == 1 else None
