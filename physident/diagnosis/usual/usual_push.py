"""How hard an arm seems to be pushed that is not: what a model errs by looks like contacts, too."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.agreement import theta_without_each
from physident.diagnosis.grading.control import UNUSUAL, rows_of_model
from physident.diagnosis.grading.grades import AS_ELSEWHERE, AS_HEALTHY
from physident.diagnosis.grading.members import without_effects
from physident.diagnosis.problem.search_data import rows_of, tool_jacobians
from physident.diagnosis.search.contact_scan import CONTACT, contact_weights, strongest_run
from physident.diagnosis.search.hypothesis import Hypothesis, rows_during
from physident.diagnosis.usual.usual_friction import FEWEST
from physident.effects.contact import PIECE, Contact
from physident.estimation.estimate import Estimate
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
NOISE = 1.0  # squared residual in units of the noise: of a run that explains less it is not known how little
AT_END = 1e-6  # s: the row at which a contact ends is not its own
HELD = 0.5  # of the rows of a contact: a run of fewer, beside a gap, is not compared with it


def pushed_as_usual(
    hypothesis: Hypothesis, estimate: Estimate | None, control: Sequence[Signals], are_fitted: bool
) -> dict[str, str]:
    """The recordings (their hashes) whose contacts look like what the model errs by without any, each with the reason: along healthy
    recordings, or at other times of the new ones."""
    contacts: dict[str, list[int]] = {}
    for i, one in enumerate(hypothesis.accepted):
        if one.candidate is CONTACT and isinstance(one.effect, Contact):
            contacts.setdefault(one.effect.recording, []).append(i)
    if not contacts:
        return {}
    usual = dict.fromkeys(_as_elsewhere(hypothesis, contacts), AS_ELSEWHERE)
    return usual | dict.fromkeys(_as_healthy(hypothesis, contacts, estimate, control, are_fitted), AS_HEALTHY)


def _as_healthy(
    hypothesis: Hypothesis,
    contacts: Mapping[str, Sequence[int]],
    estimate: Estimate | None,
    control: Sequence[Signals],
    are_fitted: bool,
) -> list[str]:
    """The recordings whose contacts explain no more than the best contact in each recording of the healthy arm would.

    Of each recording of the ``control`` and of each new one it is asked what the best run of windows explains without its strongest joint. Those
    that the model was fitted to (``are_fitted``) are predicted by the model that the others give. One of twenty healthy arms shows more in any
    new recording. Too few recordings, or none, say nothing; nor do they of a repeated motion, from which the model's error was taken off.
    """
    problem = hypothesis.problem
    asked = [k for k, one in enumerate(problem.signals) if one.recording in contacts]
    asked = [k for k in asked if k not in problem.freedom.compared]
    if not asked or estimate is None or len(control) < FEWEST:
        return []
    most = _most(_of_healthy(hypothesis, estimate, control, are_fitted), UNUSUAL / len(problem.signals))
    rest = without_effects(hypothesis, [i for some in contacts.values() for i in some])
    weights, result = contact_weights(hypothesis), list[str]()
    for k in asked:
        rows = rows_of(problem.regressor.recording, k)
        J, left = problem.jacobians[rows] * weights, rest.fit.residual[rows] * weights
        if strongest_run(J, left, problem.regressor.time[rows]) <= most:
            result.append(problem.signals[k].recording)
    return result


def _as_elsewhere(hypothesis: Hypothesis, contacts: Mapping[str, Sequence[int]]) -> list[str]:
    """The recordings none of whose contacts explains more than forces as long would at other times, of what the model leaves there.

    Chance is measured on residuals without their moments, and what a wrong law of friction leaves has moments. A contact is the best of all
    of them: one arm in twenty shows it in any. Too few other times say nothing.
    """
    pushed = np.any([_during(hypothesis, i) for some in contacts.values() for i in some], axis=0)
    return [
        recording for recording, some in contacts.items() if all(_is_as_elsewhere(hypothesis, i, pushed) for i in some)
    ]


def _is_as_elsewhere(hypothesis: Hypothesis, contact: int, pushed: NDArray[np.bool_]) -> bool:
    """Whether an accepted contact explains no more than forces would while nothing seems to push."""
    regressor, inside = hypothesis.problem.regressor, _during(hypothesis, contact)
    own = float(np.sum(_explained(hypothesis, without_effects(hypothesis, [contact]), inside)))
    windows = max(1, round(sum(end - start for start, end in _of(hypothesis, contact).intervals) / PIECE))
    others = list[float]()
    for k in range(len(hypothesis.problem.signals)):
        free = (regressor.recording == k) & ~pushed
        label, count = _window_of(hypothesis, free)
        gains = _explained(hypothesis, hypothesis, free)
        for first in range(0, len(label) - windows + 1, windows):
            some = slice(first, first + windows)
            if count[some].sum() >= HELD * inside.sum():
                others.append(float(gains[some].sum() * inside.sum() / count[some].sum()))
    return len(others) >= FEWEST and own <= _most(others, UNUSUAL / (len(others) + 1))


def _during(hypothesis: Hypothesis, contact: int) -> NDArray[np.bool_]:
    """The rows (M,) while an accepted contact lasts."""
    effect = _of(hypothesis, contact)
    ends = [(start, end - AT_END) for start, end in effect.intervals]
    return rows_during(hypothesis.problem, effect.recording, ends)


def _of(hypothesis: Hypothesis, contact: int) -> Contact:
    effect = hypothesis.accepted[contact].effect
    assert isinstance(effect, Contact)
    return effect


def _window_of(hypothesis: Hypothesis, some: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The windows of half a second that hold ``some`` rows, and how many each holds."""
    time = hypothesis.problem.regressor.time[some]
    label = np.floor((time - time[0]) / PIECE + 1e-6).astype(np.intp) if len(time) else np.zeros(0, dtype=np.intp)
    return np.unique(label, return_counts=True)


def _explained(hypothesis: Hypothesis, left: Hypothesis, some: NDArray[np.bool_]) -> Array:
    """What the best constant force at the tool explains, in units of the noise, of what is ``left`` in each window of ``some`` rows."""
    weights, (_, counts) = contact_weights(hypothesis), _window_of(hypothesis, some)
    J, residual = hypothesis.problem.jacobians[some] * weights, left.fit.residual[some] * weights
    ends = np.concatenate([[0], np.cumsum(counts)])
    gains = np.zeros(len(counts))
    for w, (first, last) in enumerate(itertools.pairwise(ends)):
        A, b = J[first:last].transpose(0, 2, 1).reshape(-1, 3), residual[first:last].ravel()
        force = np.linalg.lstsq(A, b, rcond=1e-6)[0]
        gains[w] = b @ b - np.sum((b - A @ force) ** 2)
    return gains


def _most(gains: Sequence[float], chance: float) -> float:
    """What one more gain like these exceeds with some ``chance``, by how their logarithms scatter (Student's t)."""
    from scipy.stats import t

    logs = np.log(np.maximum(gains, NOISE))
    reach = t.isf(chance, len(logs) - 1) * np.std(logs, ddof=1) * np.sqrt(1 + 1 / len(logs))
    return float(np.exp(logs.mean() + reach))


def _of_healthy(
    hypothesis: Hypothesis, estimate: Estimate, control: Sequence[Signals], are_fitted: bool
) -> list[float]:
    """What the best run explains of each control recording."""
    weights = contact_weights(hypothesis)
    rows, counted = rows_of_model(estimate.model, control, hypothesis.problem.filter)
    each = theta_without_each(estimate, control) if are_fitted else np.tile(estimate.theta, (len(control), 1))
    J = tool_jacobians(estimate.model.robot, rows, control) * (counted * weights)[:, None, :]
    found = []
    for k, theta in enumerate(each):
        mine = rows_of(rows.recording, k)
        found.append(strongest_run(J[mine], rows.residual(theta)[mine] * weights, rows.time[mine]))
    return found
