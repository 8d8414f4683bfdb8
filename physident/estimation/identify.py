"""From recordings to an estimate: prepare the signals, build the regressor, solve, and compute the uncertainty."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor
from physident.effects.catalogue import DEFAULT_EFFECTS, make_effects
from physident.effects.effect import Effect
from physident.errors import InputError
from physident.estimation.dry_friction.held_rests import hold_rests, same_sides, settle_rests, with_dry_columns
from physident.estimation.dry_friction.row_weights import row_weights
from physident.estimation.estimate import Estimate
from physident.estimation.estimated_model import Source
from physident.estimation.estimators import OLS, WLS, Estimator, Physical, Robust, make_estimator
from physident.estimation.least_squares import Solution, least_squares
from physident.estimation.physical.certificate import Certificate
from physident.estimation.physical.cones import physical_cones
from physident.estimation.robust import robust_least_squares
from physident.estimation.shapes.curve_priors import placed, with_amplitudes, with_prior
from physident.estimation.shapes.shape_parameters import settle
from physident.estimation.shapes.shape_uncertainty import ShapeSensitivities, shape_sensitivities
from physident.estimation.sizing import unsized_parameters
from physident.estimation.weighting import information_in, weight_rows
from physident.identifiability.base_parameters import BaseParameters, find_base_parameters
from physident.large_arrays import magnitude, squares
from physident.recordings.checks import check_effort, refuse_duplicates
from physident.recordings.load import Recordings, as_recordings
from physident.recordings.preparation import prepare
from physident.recordings.recording import Recording
from physident.recordings.signals import MOVING_SPEED, Filter, Signals, as_filter
from physident.robots.load import as_robot
from physident.robots.robot import Robot
from physident.setup_checks.check_setup import warn_of_setup
from physident.threads import one_thread

Array = NDArray[np.float64]
SIDES = 3  # times that an estimator may choose the sides of rests anew: others lie at their band's edge


@one_thread
def identify(
    robot: Robot | str | Path,
    recordings: Recordings,
    effects: str | Iterable[str | Effect] = DEFAULT_EFFECTS,
    method: str | Estimator = "wls",
    filter: Filter | float | None = None,
    columns: str | None = None,
) -> Estimate:
    """Identify the parameters of some effects of a robot from recordings; returns an ``Estimate``.

    ``robot`` may be a name or a path, ``recordings`` one or several recordings, paths or patterns.
    ``method`` is "ols", "wls" (each joint weighted by its residual), "robust" (outliers count linearly), "physical"
    (physically consistent, with a prior), or an object ``OLS``, ``WLS``, ``Robust``, ``Physical`` with settings.
    ``effects`` are names or objects, or one text of names separated by commas; ``filter`` may be its cutoff [Hz].
    ``columns`` is the layout of files, stored in the estimate as the default layout of others. Recordings are held against the
    robot's description first, see ``check_setup``: what is wrong is a warning, and in the estimate's ``warnings``. Raises InputError for
    recordings that do not fit the robot, for a joint that never moves although an effect acts on it alone, for efforts
    that cannot be the arm's, and for a prior or bounds that do not fit the model; NotSolvedError where the estimator does
    not settle, constraints contradict, or an answer cannot be proved. Source: thesis eq. 3.61-3.64.
    """
    estimator = make_estimator(method)
    robot = as_robot(robot)
    recordings = as_recordings(recordings, robot, columns)
    if not recordings:
        raise InputError("no recordings given, expected at least one")
    filter, initial = as_filter(filter), make_effects(effects)
    signals = prepare_all(robot, recordings, filter)
    refuse_duplicates(recordings)
    warnings = warn_of_setup(robot, recordings)
    _refuse_free_scale(robot, initial)
    _refuse_still_joints(robot, initial, signals)
    initial = placed(robot, initial, signals)
    settled, regressor = settle(robot, initial, signals, filter)
    _refuse_brief(recordings, regressor)
    if not isinstance(estimator, OLS):
        signals, regressor = settle_rests(robot, settled, regressor, signals, filter)

    def counted() -> Regressor:  # all rows alike for ordinary least squares
        weighted = not isinstance(estimator, OLS)
        return (
            weight_rows(regressor, row_weights(robot, settled, regressor, signals, filter)) if weighted else regressor
        )

    settled, sides = with_amplitudes(robot, settled, counted()), 0
    while True:
        rows = counted()
        estimate = estimate_from(robot, settled, rows, recordings, estimator, filter, columns)
        sides += 1
        if isinstance(estimator, OLS) or sides == SIDES:
            break
        held = hold_rests(estimate.model, signals)
        if same_sides(signals, held):
            break
        signals, regressor = held, with_dry_columns(estimate.model, regressor, held, filter)
    sensitivities = shape_sensitivities(robot, initial, settled, estimate.theta, signals, filter)
    return replace(with_shape_uncertainty(estimate, rows, sensitivities), warnings=warnings)


def with_shape_uncertainty(estimate: Estimate, regressor: Regressor, sensitivities: ShapeSensitivities) -> Estimate:
    """The estimate with the uncertainty of its shape parameters added: to first order each is one more column."""
    robot, effects = estimate.model.robot, estimate.model.effects
    if not sensitivities.places:
        return estimate
    extended, base = sensitivities.added_to(regressor, estimate.base)
    nominal = np.concatenate([Model.nominal(robot, effects).theta, np.zeros(len(sensitivities.places))])
    noise = "equal" if estimate.method == "ols" else "diagonal"
    covariance = least_squares(extended, base, nominal, noise).covariance
    r = estimate.base.r
    # the covariance of a physical estimate also contains its prior: only the shape parameters' part is added to it
    alone = least_squares(regressor, estimate.base, nominal[: len(estimate.theta)], noise).covariance
    added = covariance[:r, :r] - alone
    total = covariance[:r, :r] if estimate.method in ("ols", "wls") else estimate.covariance + _positive(added)
    return replace(estimate, covariance=total, shape_parameters=sensitivities.found(robot, effects, covariance))


def _positive(matrix: Array) -> Array:
    """The nearest symmetric matrix (r, r) without negative eigenvalues, which rounding of a difference may cause."""
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2)
    return (vectors * np.maximum(values, 0.0)) @ vectors.T


def prepare_all(robot: Robot, recordings: Sequence[Recording], filter: Filter) -> list[Signals]:
    """Signals of recordings; raises InputError, naming the file, for another number of joints, no motion, or torques that
    cannot be the robot's."""
    signals = prepare_moving(robot, recordings, filter)
    check_effort(recordings, robot)
    return signals


def prepare_moving(robot: Robot, recordings: Sequence[Recording], filter: Filter) -> list[Signals]:
    """Signals as from ``prepare_all`` without a check of the efforts: for inspection, or where drive gains are unknown."""
    signals = []
    for recording in recordings:
        if recording.n != robot.n:
            raise InputError(
                f"{recording.source}: {recording.n} joints, but robot {robot.name} has {robot.n}; check --robot, --joints and --columns"
            )
        one = prepare(recording, filter)
        if one.moving is None:
            raise InputError(f"{recording.source}: no joint moves faster than 0.02 rad/s; expected a motion")
        signals.append(one)
    return signals


def estimate_from(
    robot: Robot,
    effects: tuple[Effect, ...],
    regressor: Regressor,
    recordings: Sequence[Recording],
    method: str | Estimator,
    filter: Filter,
    columns: str | None = None,
) -> Estimate:
    """The estimate of a regressor that is already built."""
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


def _refuse_brief(recordings: Sequence[Recording], regressor: Regressor) -> None:
    """A recording whose motion is shorter than the filter leaves no rows, and fewer rows than parameters fit anything."""
    for index, recording in enumerate(recordings):
        if not (regressor.recording == index).any():
            raise InputError(f"{recording.source}: its motion is shorter than the filter; expected seconds of motion")
    if (rows := int(regressor.counted.sum())) < len(regressor.columns):
        names = ", ".join(recording.source for recording in recordings)
        raise InputError(
            f"{names}: {rows} values are left after the filter, fewer than the {len(regressor.columns)} parameters;"
            " expected seconds of motion"
        )


def _refuse_free_scale(robot: Robot, effects: Sequence[Effect]) -> None:
    """With every joint's torque constant and every mass free, the scale of all torques is undetermined."""
    scaled = {joint for e in effects if e.name == "torque_constant" for joint in e.active(robot)}
    if len(scaled) == robot.n and any(effect.name == "rigid_body" for effect in effects):
        raise InputError(
            "torque_constant on every joint beside rigid_body leaves the scale of all torques free;"
            " expected at least one joint without it, or drive gains from a known load (physident drive-gains)"
        )


def _refuse_still_joints(robot: Robot, effects: Sequence[Effect], signals: Sequence[Signals]) -> None:
    """The friction and rotor inertia of a joint that never moves cannot be identified: their columns are zero."""
    speed = np.max([magnitude(one.v) for one in signals], axis=0)
    rest = Model.nominal(robot).refer(Signals.of_states(*np.zeros((3, 1, robot.n))))
    for j in np.flatnonzero(speed < MOVING_SPEED):
        hidden = []
        for effect in effects:
            rows = effect.pattern(robot)
            if not effect.pointwise or effect.shape_parameters:
                continue
            on_joint = rows[:, 0] == j
            if effect.name == "rigid_body" or not on_joint.any():
                continue
            if not np.abs(effect.values(robot, rest)[on_joint]).any():
                hidden.append(effect.name)
        if hidden:
            raise InputError(
                f"joint {j + 1} ({robot.joint_names[j]}) never moves faster than {MOVING_SPEED} rad/s in any recording:"
                f" nothing shows its {', '.join(hidden)}; record a motion of joint {j + 1}, or leave it out of these effects"
            )


def _relative(regressor: Regressor, theta: Array) -> Array:
    size = np.sqrt(squares(regressor.torque))
    return 100 * np.sqrt(squares(regressor.residual(theta))) / np.where(size > 0, size, 1.0)


def _source(index: int, recording: Recording, regressor: Regressor) -> Source:
    used = np.count_nonzero(regressor.recording == index) / regressor.kept_rate
    return Source(recording.source, recording.sha256, recording.duration, float(used))


def shared_gains(recordings: Sequence[Recording]) -> tuple[float, ...] | None:
    """The drive gains (n,) [N m/A] of recordings of current, None where they have none or differ."""
    gains = {recording.drive_gains for recording in recordings if recording.effort_kind == "current"}
    return gains.pop() if len(gains) == 1 else None
