"""Errors per joint before and after a diagnosis, on a holdout or on left-out rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.remainder.unexplained import Unexplained
from physident.diagnosis.repeated.comparison import Comparison
from physident.diagnosis.result.findings import JointErrors
from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.dynamics.regressor import build_regressor
from physident.estimation.dry_friction.rest import rest_rows
from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.large_arrays import steps
from physident.recordings.recording import Recording
from physident.recordings.rows import typical_step
from physident.validation.scores import compared, scored

Array = NDArray[np.float64]
ERRS_MORE = "the extended model errs by more than the model"
FAR = 2.0  # times an error: noise is as large on any motion, and a change that was compared may add to an error of the model's or cancel one, not double it on all joints


def errors_before_and_after(
    given: Estimate,
    first: Hypothesis,
    last: Hypothesis,
    extended: Estimate | None,
    recordings: Sequence[Recording],
    holdout: Sequence[Recording],
    comparison: Comparison | None = None,
) -> tuple[JointErrors, JointErrors]:
    """Errors of the model as ``given`` and of the extended one: on the holdout where there is one, else on left-out rows.

    Where the search began from a model with more than was given, the given one is scored on the new recordings as it is: it
    never saw any of their rows. What a ``comparison`` has taken off the torque is part of both errors.
    """
    if not holdout:
        if first.problem.model is given.model:
            return _left_out_errors(first, comparison), _left_out_errors(last, comparison)
        score = scored(given, recordings)
        return JointErrors(score.rms, score.relative_all), _left_out_errors(last, comparison)
    if extended is None:
        score = scored(given, holdout)
        errors = JointErrors(score.rms, score.relative_all)
        return errors, errors
    gain = compared(given, extended, on=holdout)
    return JointErrors(gain.before.rms, gain.before.relative_all), JointErrors(gain.after.rms, gain.after.relative_all)


def refutes(given: Estimate, before: JointErrors, after: JointErrors, unseen: bool = False) -> str:
    """Why an extended model cannot be handed on: it errs by far more than the ``given`` one, pooled over the joints in units of what that
    left on its own recordings; empty where it does not. Errors on an ``unseen`` holdout may also be those of an arm that had not changed yet.
    """
    size = np.maximum(given.sigma, 1e-300)
    times = float(np.linalg.norm(after.rms / size) / max(np.linalg.norm(before.rms / size), 1e-300))
    if times < FAR:
        return ""
    either, holdout = (
        ("either the holdout was recorded before the change, or ", "a holdout from after it, ") if unseen else ("", "")
    )
    return (
        f"the extended model errs {times:.1f} times as much as the model, so it is not handed on: {either}the model does not describe the arm"
        f" of the recordings from before; give {holdout}the model of that arm, or its recordings as --before"
    )


def beyond_noise(
    model: Estimate,
    diagnosed: Sequence[Recording],
    holdout: Sequence[Recording],
    errors: JointErrors,
    unexplained: Sequence[Unexplained],
    noise_floor: Array | None,
    changed: Estimate | None,
) -> tuple[int, ...]:
    """Joints (from 1) on which a model's ``errors`` on a holdout are no noise: far above what is left of the diagnosed recordings, or does not
    repeat, and what the values of the model leave open. What a model that has ``changed`` left on its own recordings is no change."""
    levels = [np.array([one.rms for one in unexplained]), noise_floor, changed.sigma if changed else None]
    # white noise through one filter has a power that falls with the rate
    period, before = (np.mean([typical_step(one.time) for one in some]) for some in (holdout, diagnosed))
    level = np.sqrt(max(1.0, period / before)) * np.max([one for one in levels if one is not None], axis=0)
    return tuple(int(j) + 1 for j in np.flatnonzero(errors.rms > FAR * np.hypot(level, _left_open(model, holdout))))


def _left_open(estimate: Estimate, recordings: Sequence[Recording]) -> Array:
    """RMS (n,) [N m|N] of the standard error of what a model predicts of recordings, from that of its base parameters."""
    model, filter, base = estimate.model, estimate.filter, estimate.base.independent
    given = [recording.with_default_drive_gains(estimate.drive_gains) for recording in recordings]
    regressor = build_regressor(
        model.robot, model.effects, prepare_all(model.robot, given, filter), filter, theta=model.theta
    )
    result = []
    for rows in regressor.joints:
        own = np.flatnonzero(np.isin(base, rows.columns))
        places = np.searchsorted(rows.columns, base[own])
        covariance, squares = estimate.covariance[np.ix_(own, own)], 0.0
        for some in steps(len(regressor.time)):
            Y = rows.some(some)[:, places]
            squares += float(np.sum((Y @ covariance) * Y))
        result.append(np.sqrt(max(squares, 0.0) / len(regressor.time)))
    return np.array(result)


def _left_out_errors(hypothesis: Hypothesis, comparison: Comparison | None) -> JointErrors:
    problem, regressor = hypothesis.problem, hypothesis.data.regressor
    residual, torque = hypothesis.left_out_fits.residual() / problem.weights, hypothesis.torque
    inside, rest_friction = hypothesis.in_folds, hypothesis.rest_friction
    if comparison is not None:
        taken_off = comparison.taken_off(problem.model, problem.filter) * regressor.counted
        residual, torque = residual + taken_off, torque + taken_off
        rests = rest_rows(hypothesis.extension.model, comparison.untouched, problem.filter)
        rest_friction = rests.friction * regressor.counted
    residual = residual - rest_friction
    relative = []
    for index in np.unique(regressor.recording[inside]):
        rows = inside & (regressor.recording == index)
        size = np.linalg.norm(torque[rows], axis=0)
        relative.append(100 * np.linalg.norm(residual[rows], axis=0) / np.where(size > 0, size, 1.0))
    rows = np.maximum(regressor.counted[inside].sum(axis=0), 1)
    return JointErrors(np.sqrt((residual[inside] ** 2).sum(axis=0) / rows), np.mean(relative, axis=0))


def error_table(d: DiagnosisRecord) -> list[str]:
    """The rows of the table; beside errors on left-out rows those of the fit, where these are far smaller."""
    count, unit = len(d.before.rms), d.model.robot.torque_unit
    rows = [f"error on {d.scored_on}, cutoff {d.filter.cutoff:g} Hz" + "".join(f"{j:>9d}" for j in range(1, count + 1))]
    width = len(rows[0]) - 9 * count
    for label, level in (("before", d.before), ("after", d.after)):
        rows.append(f"  RMS {label} [{unit}]".ljust(width) + "".join(map(_cell, level.rms)))
    fitted = np.array([one.rms for one in d.unexplained])
    compared = any(used.repeats is not None for used in d.recordings)  # of which the fitted rows are differences
    unlike = len(fitted) == count and d.scored_on != "holdout" and not compared
    if unlike and (d.after.rms > FAR * fitted).any():
        rows.append(f"  RMS as fitted [{unit}]".ljust(width) + "".join(map(_cell, fitted)))
        rows.append(
            "  as fitted: far smaller where one stretch of the recordings alone shows a part of the motion; record it again"
        )
    if d.noise_floor is not None:
        rows.append(f"  noise floor [{unit}]".ljust(width) + "".join(map(_cell, d.noise_floor)))
    else:
        within = " within these recordings" if compared else ""
        rows.append(f"  noise floor: not known, because no motion was repeated{within}")
    if d.scored_on != "holdout" and any(f.intervals for f in d.findings):
        rows.append("  after: contact rows are excluded, because no other recording can predict a contact force")
    if d.missing_since_before:
        rows.append("  after: with what is missing since before, too")
    for label, level in (("before", d.before), ("after", d.after)):
        rows.append(f"  relative {label} [%]".ljust(width) + "".join(f"{x:9.2f}" for x in level.relative))
    return rows


def _cell(value: float) -> str:
    """A number in a column of nine characters, apart from the one before it."""
    text = f"{value:.4g}"
    return f"{text if len(text) < 9 else f'{value:.2e}':>9}"
