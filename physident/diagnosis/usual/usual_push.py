"""How hard a healthy arm seems to be pushed: what a model errs by looks like contacts, too."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.agreement import theta_without_each
from physident.diagnosis.grading.control import UNUSUAL, rows_of_model
from physident.diagnosis.grading.members import without_effects
from physident.diagnosis.problem.search_data import rows_of, tool_jacobians
from physident.diagnosis.search.contact_scan import CONTACT, contact_weights, strongest_run
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.usual.usual_friction import FEWEST
from physident.effects.contact import Contact
from physident.estimation.estimate import Estimate
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
NOISE = 1.0  # squared residual in units of the noise: of a run that explains less it is not known how little


def pushed_as_usual(
    hypothesis: Hypothesis, estimate: Estimate | None, control: Sequence[Signals], are_fitted: bool
) -> frozenset[str]:
    """The recordings (their hashes) whose contacts explain no more than the best contact in each recording of the healthy arm would.

    Of each recording of the ``control`` and of each new one it is asked what the best run of windows explains without its strongest joint. Those
    that the model was fitted to (``are_fitted``) are predicted by the model that the others give. One of twenty healthy arms shows more in any
    new recording, by how the logarithms scatter (Student's t; Bonferroni over the recordings). Too few recordings, or none, say nothing; nor do
    they of a repeated motion, from which the model's error was taken off.
    """
    from scipy.stats import t

    problem = hypothesis.problem
    contacts = [i for i, one in enumerate(hypothesis.accepted) if one.candidate is CONTACT]
    effects = [hypothesis.accepted[i].effect for i in contacts]
    pushed = {one.recording for one in effects if isinstance(one, Contact)}
    asked = [k for k, one in enumerate(problem.signals) if one.recording in pushed]
    asked = [k for k in asked if k not in problem.freedom.compared]
    if not asked or estimate is None or len(control) < FEWEST:
        return frozenset()
    healthy = np.log(np.maximum(_of_healthy(hypothesis, estimate, control, are_fitted), NOISE))
    level = 1 - UNUSUAL / len(problem.signals)
    reach = t.ppf(level, len(healthy) - 1) * np.std(healthy, ddof=1) * np.sqrt(1 + 1 / len(healthy))
    most = float(np.exp(healthy.mean() + reach))
    rest, weights = without_effects(hypothesis, contacts), contact_weights(hypothesis)
    result = set[str]()
    for k in asked:
        rows = rows_of(problem.regressor.recording, k)
        J, left = problem.jacobians[rows] * weights, rest.fit.residual[rows] * weights
        if strongest_run(J, left, problem.regressor.time[rows]) <= most:
            result.add(problem.signals[k].recording)
    return frozenset(result)


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
