"""From recordings to an estimate: prepare, stack, solve, and say how sure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor
from physident.effects.catalogue import DEFAULT_EFFECTS, make_effects
from physident.effects.effect import Effect
from physident.errors import InputError
from physident.estimation.estimate import Estimate, Source
from physident.estimation.estimators import WLS, Estimator, Physical, Robust, make_estimator
from physident.estimation.least_squares import least_squares
from physident.estimation.nearest import nearest_to
from physident.estimation.physical.certificate import Certificate
from physident.estimation.physical.cones import physical_cones
from physident.estimation.robust import robust_least_squares
from physident.estimation.shape_errors import Slopes, shape_slopes
from physident.estimation.shapes import settle
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.checks import check_effort, refuse_twice
from physident.recordings.recording import Recording
from physident.recordings.signals import MOVING_SPEED, Filter, Signals, prepare
from physident.robots.robot import Robot

Array = NDArray[np.float64]


def identify(
    robot: Robot,
    recordings: Sequence[Recording],
    effects: Iterable[str | Effect] = DEFAULT_EFFECTS,
    method: str | Estimator = "wls",
    filter: Filter | None = None,
    columns: str | None = None,
) -> Estimate:
    """Identify the parameters of some effects of a robot from recordings; returns an ``Estimate``.

    ``method`` is "ols", "wls" (each joint by its own residual), "robust" (outliers count linearly), "physical" (only
    what a real arm can be, with a prior), or one of the objects of these names with its settings. ``columns`` is only
    remembered in the estimate. Raises InputError for recordings that do not fit the robot or where a joint with
    effects of its own never moves, for efforts that cannot be the arm's, for a prior or bounds that do not fit the model; NotSolvedError where the estimator
    does not settle, bounds contradict, or an answer cannot be proved. Source: thesis eq. 3.61-3.64.
    """
    estimator = make_estimator(method)
    if not recordings:
        raise InputError("no recordings given, expected at least one")
    filter = filter or Filter()
    made = make_effects(effects)
    signals = prepare_all(robot, recordings, filter)
    refuse_twice(recordings)
    _refuse_free_scale(robot, made)
    _refuse_still_joints(robot, made, signals)
    found, regressor = settle(robot, made, signals, filter)
    estimate = estimate_from(robot, found, regressor, recordings, estimator, filter, columns)
    slopes = shape_slopes(robot, made, found, estimate.theta, signals, filter)
    return with_shape_errors(estimate, regressor, slopes)


def with_shape_errors(estimate: Estimate, regressor: Regressor, slopes: Slopes) -> Estimate:
    """The estimate with what the uncertainty of its found shapes adds: to first order a shape is one more column."""
    robot, effects = estimate.model.robot, estimate.model.effects
    if not slopes.places:
        return estimate
    grown, base = slopes.added_to(regressor, estimate.base)
    nominal = np.concatenate([Model.nominal(robot, effects).theta, np.zeros(len(slopes.places))])
    noise = "equal" if estimate.method == "ols" else "diagonal"
    covariance = least_squares(grown, base, nominal, noise).covariance
    r = estimate.base.r
    # a physical estimate's own covariance also holds what its prior knows: only the shapes' share is added to it
    added = (
        covariance[:r, :r] - least_squares(regressor, estimate.base, nominal[: len(estimate.theta)], noise).covariance
    )
    total = covariance[:r, :r] if estimate.method in ("ols", "wls") else estimate.covariance + _positive(added)
    return replace(estimate, covariance=total, shapes=slopes.found(robot, effects, covariance))


def _positive(matrix: Array) -> Array:
    """The nearest symmetric matrix (r, r) without negative eigenvalues: noise of a difference is no certainty."""
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2)
    return (vectors * np.maximum(values, 0.0)) @ vectors.T


def prepare_all(robot: Robot, recordings: Sequence[Recording], filter: Filter) -> list[Signals]:
    """Signals of recordings that each have the robot's joints, some motion, and torques that can be the robot's own; raises
    InputError naming the file."""
    signals = prepare_moving(robot, recordings, filter)
    check_effort(recordings, robot)
    return signals


def prepare_moving(robot: Robot, recordings: Sequence[Recording], filter: Filter) -> list[Signals]:
    """Signals as ``prepare_all`` makes them, whatever the efforts: to look at a recording, or where their unit is sought."""
    signals = []
    for recording in recordings:
        if recording.n != robot.n:
            raise InputError(
                f"{recording.source}: {recording.n} joints, but robot {robot.name} has {robot.n}; check --robot and --columns"
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
    """The estimate of a regressor that is already built: what ``identify`` and left-out studies share."""
    estimator = make_estimator(method)
    base = find_base_parameters(robot, effects)
    nominal = Model.nominal(robot, effects).theta
    sources = tuple(_source(i, recording, regressor) for i, recording in enumerate(recordings))
    if isinstance(estimator, Physical):
        from physident.estimation.physical.consistent import solve_physical  # cvxpy takes a second to import

        found = solve_physical(regressor, base, robot, effects, nominal, estimator)
        return Estimate(
            Model(robot, effects, found.theta), estimator, found.covariance, found.sigma,
            _relative(regressor, found.theta), found.effective_samples, found.certificate, filter, sources,
            columns, shared_gains(recordings), found.blocks, found.prior_weight,
            tuple(float(s) for s in found.decision.shares), tuple(float(s) for s in found.decision.base), found.held,
        )  # fmt: skip
    if isinstance(estimator, Robust):
        solution = robust_least_squares(regressor, base, nominal, estimator.threshold)
    else:
        noise = estimator.noise if isinstance(estimator, WLS) else "equal"
        solution = least_squares(regressor, base, nominal, noise)
    theta = nearest_to(nominal, base, solution.base)
    matrices = physical_cones(robot, effects).matrices
    certificate = Certificate(
        solution.stationarity, solution.condition, int(solution.determined.sum()), solution.iterations,
        eigenvalues=tuple(smallest_share(m.at(theta)) for m in matrices),
    )  # fmt: skip
    return Estimate(
        Model(robot, effects, theta), estimator, solution.covariance, solution.sigma, _relative(regressor, theta),
        solution.effective_samples, certificate, filter, sources, columns, shared_gains(recordings), solution.blocks,
        base_shares=tuple(float(d) for d in solution.determined),
    )  # fmt: skip


def smallest_share(P: Array) -> float:
    """Smallest eigenvalue of a symmetric matrix over its largest in size; zero for a zero matrix."""
    values = np.linalg.eigvalsh(P)
    size = float(np.abs(values).max())
    return float(values[0]) / size if size > 0 else 0.0


def _refuse_free_scale(robot: Robot, effects: Sequence[Effect]) -> None:
    """With every joint's torque constant free and every mass too, the scale of all torques is anybody's choice."""
    scaled = {joint for e in effects if e.name == "torque_constant" for joint in e.active(robot)}
    if len(scaled) == robot.n and any(effect.name == "rigid_body" for effect in effects):
        raise InputError(
            "torque_constant on every joint beside rigid_body leaves the scale of all torques free;"
            " expected at least one joint without it, or drive gains from a known load (physident drive-gains)"
        )


def _refuse_still_joints(robot: Robot, effects: Sequence[Effect], signals: Sequence[Signals]) -> None:
    """A joint that never moves hides its own friction and rotor: columns that vanish without its motion."""
    speed = np.max([np.abs(one.v).max(axis=0) for one in signals], axis=0)
    rest = Model.nominal(robot).refer(Signals.of_states(*np.zeros((3, 1, robot.n))))
    for j in np.flatnonzero(speed < MOVING_SPEED):
        hidden = []
        for effect in effects:
            rows = effect.pattern(robot)
            if not effect.pointwise or effect.shape_parameters:
                continue
            own = effect.name != "rigid_body" and (rows[:, 0] == j).any()
            if own and not np.abs(effect.values(robot, rest)[rows[:, 0] == j]).any():
                hidden.append(effect.name)
        if hidden:
            raise InputError(
                f"joint {j + 1} ({robot.joint_names[j]}) never moves faster than {MOVING_SPEED} rad/s in any recording:"
                f" nothing shows its {', '.join(hidden)}; record a motion of joint {j + 1}, or leave it out of these effects"
            )


def _relative(regressor: Regressor, theta: Array) -> Array:
    residual = regressor.torque - regressor.predict(theta)
    size = np.linalg.norm(regressor.torque, axis=0)
    return 100 * np.linalg.norm(residual, axis=0) / np.where(size > 0, size, 1.0)


def _source(index: int, recording: Recording, regressor: Regressor) -> Source:
    used = np.count_nonzero(regressor.recording == index) / regressor.kept_rate
    return Source(recording.source, recording.sha256, recording.duration, float(used))


def shared_gains(recordings: Sequence[Recording]) -> tuple[float, ...] | None:
    """The drive gains (n,) [N m/A] of recordings of current, None where they have none or differ."""
    gains = {recording.drive_gains for recording in recordings if recording.effort_kind == "current"}
    return gains.pop() if len(gains) == 1 else None
