"""From recordings to an estimate: prepare, stack, solve, and say how sure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from physident.base_parameters import BaseParameters, find_base_parameters
from physident.effects.catalogue import DEFAULT_EFFECTS, make_effects
from physident.effects.effect import Effect
from physident.errors import InputError
from physident.estimation.estimate import Certificate, Estimate, Source
from physident.estimation.least_squares import least_squares
from physident.model import Model
from physident.recording import Recording
from physident.regressor import Regressor, build_regressor
from physident.robot import Robot
from physident.signals import Filter, Signals, prepare

Array = NDArray[np.float64]
METHODS = ("wls", "ols")


def identify(
    robot: Robot,
    recordings: Sequence[Recording],
    effects: Iterable[str | Effect] = DEFAULT_EFFECTS,
    method: str = "wls",
    filter: Filter | None = None,
    columns: str | None = None,
) -> Estimate:
    """Identify the parameters of some effects of a robot from recordings; returns an ``Estimate``.

    ``method`` "wls" weighs each joint by its own residual, "ols" does not. ``columns`` is only remembered in the
    estimate. Raises InputError for recordings that do not fit the robot or where no joint moves, NotSolvedError where
    the estimator does not settle. Source: thesis eq. 3.61-3.64.
    """
    if method not in METHODS:
        raise InputError(f"method {method!r} is unknown, expected one of {', '.join(METHODS)}")
    if not recordings:
        raise InputError("no recordings given, expected at least one")
    filter = filter or Filter()
    made = make_effects(effects)
    regressor = build_regressor(robot, made, prepare_all(robot, recordings, filter), filter)
    return estimate_from(robot, made, regressor, recordings, method, filter, columns)


def prepare_all(robot: Robot, recordings: Sequence[Recording], filter: Filter) -> list[Signals]:
    """Signals of recordings that each have the robot's joints and some motion; raises InputError naming the file."""
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
    method: str,
    filter: Filter,
    columns: str | None = None,
) -> Estimate:
    """The estimate of a regressor that is already built: what ``identify`` and left-out studies share."""
    base = find_base_parameters(robot, effects)
    nominal = Model.nominal(robot, effects).theta
    solution = least_squares(regressor, base, nominal, weighted=method == "wls")
    model = Model(robot, effects, nearest_to(nominal, base, solution.base))
    residual = regressor.torque - regressor.predict(model.theta)
    size = np.linalg.norm(regressor.torque, axis=0)
    relative = 100 * np.linalg.norm(residual, axis=0) / np.where(size > 0, size, 1.0)
    certificate = Certificate(
        solution.stationarity, solution.condition, int(solution.determined.sum()), solution.iterations
    )
    return Estimate(
        model, method, solution.covariance, solution.sigma, relative, solution.effective_samples, certificate, filter,
        tuple(_source(i, recording, regressor) for i, recording in enumerate(recordings)),
        columns, _shared_gains(recordings),
    )  # fmt: skip


def nearest_to(nominal: Array, base: BaseParameters, values: Array) -> Array:
    """The parameters (p,) nearest to ``nominal`` whose base parameters are ``values`` (r,): what no motion can show
    stays where the robot's description has it."""
    K = base.grouping
    return nominal + K.T @ np.linalg.solve(K @ K.T, values - K @ nominal)


def _source(index: int, recording: Recording, regressor: Regressor) -> Source:
    used = np.count_nonzero(regressor.recording == index) / regressor.kept_rate
    return Source(recording.source, recording.sha256, recording.duration, float(used))


def _shared_gains(recordings: Sequence[Recording]) -> tuple[float, ...] | None:
    gains = {recording.drive_gains for recording in recordings if recording.effort_kind == "current"}
    return gains.pop() if len(gains) == 1 else None
