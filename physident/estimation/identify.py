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
from physident.effects.measurement import TorqueConstant
from physident.effects.scales.torque_scale import TorqueScale
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.estimation.estimators import Estimator, make_estimator
from physident.estimation.least_squares import least_squares
from physident.estimation.regressor_fit import fit_with_rests, shared_layout
from physident.estimation.shapes.curve_priors import are_near, is_placed_by_model, placed
from physident.estimation.shapes.shape_parameters import settle
from physident.estimation.shapes.shape_uncertainty import ShapeSensitivities, shape_sensitivities
from physident.large_arrays import magnitude
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
PLACED = 3  # times again at most: each fit gives the torque whose range the next one's curves have


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
    ``columns`` is the layout of files, by default the one that the recordings were read with; the estimate stores it as that of others. Recordings are held against the
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
    columns = shared_layout(recordings) if columns is None else columns
    filter, initial = as_filter(filter), make_effects(effects)
    signals = prepare_all(robot, recordings, filter)
    refuse_duplicates(recordings)
    warnings = warn_of_setup(robot, recordings)
    _refuse_free_scale(robot, initial)
    _refuse_still_joints(robot, initial, signals)

    def fit(effects: tuple[Effect, ...]) -> tuple[Estimate, Regressor, Sequence[Signals]]:
        settled, regressor = settle(robot, effects, signals, filter)
        _refuse_brief(recordings, regressor)
        return fit_with_rests(robot, settled, regressor, signals, recordings, estimator, filter, columns)

    given, initial = initial, placed(robot, initial, signals)
    fitted = fit(initial)
    for _ in range(PLACED if any(map(is_placed_by_model, given)) else 0):
        again = placed(robot, given, signals, fitted[0].model)
        if are_near(again, initial):
            break
        initial, fitted = again, fit(again)
    estimate, rows, turned = fitted
    sensitivities = shape_sensitivities(robot, initial, estimate.model.effects, estimate.theta, turned, filter)
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
    """With every joint's torque constant, or the scale of all torques, and every mass free, the scale of all torques is undetermined."""
    if not any(effect.name == "rigid_body" for effect in effects):
        return
    one = any(isinstance(e, TorqueScale) for e in effects)
    scaled = {joint for e in effects if isinstance(e, TorqueConstant) for joint in e.active(robot)}
    if one or len(scaled) == robot.n:
        name, fewer = (
            (TorqueScale.name, "none") if one else ("torque_constant on every joint", "at least one joint without it")
        )
        raise InputError(
            f"{name} beside rigid_body leaves the scale of all torques free;"
            f" expected {fewer}, or drive gains from a known load (physident drive-gains)"
        )


def _refuse_still_joints(robot: Robot, effects: Sequence[Effect], signals: Sequence[Signals]) -> None:
    """The friction and rotor inertia of a joint that never moves cannot be identified: their columns are zero."""
    speed = np.max([magnitude(one.v) for one in signals], axis=0)
    rest = Model.nominal(robot).refer(Signals.of_states(*np.zeros((3, 1, robot.n))))
    for j in np.flatnonzero(speed < MOVING_SPEED * robot.radian):
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
                f"joint {j + 1} ({robot.joint_names[j]}) never moves faster than"
                f" {MOVING_SPEED * robot.radian[j]:g} {robot.joints[j].unit('rad/s')} in any recording:"
                f" nothing shows its {', '.join(hidden)}; record a motion of joint {j + 1}, or leave it out of these effects"
            )
