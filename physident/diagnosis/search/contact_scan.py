"""Contact: a force on the tool that no other recording predicts, so each joint is tested by the force fitted to the others.

In each window of half a second, the force is fitted to all joints but one and scored on the remaining joint, which feels it
through its own row of the Jacobian. An interval is the run of windows, at most half a recording, with the largest sum of gains.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import STIFF, Candidate, Option
from physident.diagnosis.problem.search_data import OUTSIDE
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.left_out_gains import evidence_of
from physident.diagnosis.statistics.left_out_residuals import reduction_percent
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.effects.contact import PIECE, Contact, tool_jacobian

Array = NDArray[np.float64]
PHASES = (0.0, PIECE / 2)  # s: where windows begin; an edge is then at most an eighth of a second off
LONGEST = 0.5  # of a recording: what lasts longer is no passing contact but a change of the arm
CONTACT = Candidate("contact", (), (Option(None, ()),))


@dataclass(frozen=True, eq=False)
class ContactScan:
    """The best contact for each of S responses.

    ``evidence`` (S,) and ``evidence_without_best_joint`` (S,), what is left of it without its strongest joint. For the first
    response: its ``effect``, the gains of its pieces ``windows`` (W, n), the ``reduction`` [%] of RMS over all joints of
    its recording, and ``joint_reduction`` [%], that of the joint it loads most, over all recordings.
    """

    evidence: Array
    evidence_without_best_joint: Array
    effect: Contact
    windows: Array
    reduction: float
    joint_reduction: float


def scan_contacts(hypothesis: Hypothesis, responses: Array) -> ContactScan:
    """The best contact for each of some responses (M, n, S) beside a hypothesis' baseline."""
    fit, regressor = hypothesis.fit, hypothesis.data.regressor
    residual = _residual(hypothesis, responses) * fit.weights[:, None]
    before = np.einsum("mjs,mjs->js", residual, residual)
    best, gain = np.full(residual.shape[2], -np.inf), np.zeros(before.shape)
    effect, windows, reduction = Contact(), np.zeros((0, len(fit.weights))), 0.0
    for index, signals in enumerate(hypothesis.problem.signals):
        rows = regressor.recording == index
        time = regressor.time[rows] - signals.origin
        at = np.clip(np.searchsorted(signals.time, regressor.time[rows]), 0, len(signals.time) - 1)
        J = tool_jacobian(hypothesis.problem.model.robot, signals.q[at]) * fit.weights
        J = J * (hypothesis.problem.weights * regressor.counted)[rows][:, None, :]
        for phase in PHASES:
            start = np.floor(time[0] / PIECE) * PIECE + phase
            label = np.floor((time - start) / PIECE).astype(int)
            gains_of_windows = _windows(J[label >= 0], residual[rows][label >= 0], label[label >= 0])
            first, last = _intervals(gains_of_windows.sum(axis=1))
            sums = np.concatenate([np.zeros((1, *gains_of_windows.shape[1:])), np.cumsum(gains_of_windows, axis=0)])
            every = np.arange(residual.shape[2])
            found = sums[last, :, every].T - sums[first, :, every].T
            better = found.sum(axis=0) > best
            best, gain = np.where(better, found.sum(axis=0), best), np.where(better, found, gain)
            if better[0]:
                ends = (float(start + first[0] * PIECE), float(start + last[0] * PIECE))
                effect, windows = (
                    Contact(intervals=(ends,), recording=signals.recording),
                    gains_of_windows[first[0] : last[0], :, 0],
                )
                left = 1 - float(found[:, 0].sum()) / max(float(np.sum(residual[rows][:, :, 0] ** 2)), 1e-300)
                reduction = 100 * (1 - float(np.sqrt(max(left, 0.0))))
    independent = regressor.counted.sum(axis=0) / fit.memory
    each = np.array([evidence_of(before[[j]], gain[[j]], independent[[j]]) for j in range(len(independent))])
    joint_reduction = reduction_percent(before[:, 0], before[:, 0] - gain[:, 0])
    return ContactScan(
        each.sum(axis=0), each.sum(axis=0) - each.max(axis=0), effect, windows, reduction, joint_reduction
    )


def _residual(hypothesis: Hypothesis, responses: Array) -> Array:
    """What the baseline leaves of responses (M, n, S) in each fold when it is fitted to the others; in gaps, to all.

    A contact lies inside a fold: a baseline that was fitted to its rows would have taken a part of it.
    """
    weights, joints, fold = hypothesis.fit.weights, hypothesis.baseline.joints, hypothesis.data.fold
    residual, sums = np.empty_like(responses), {}
    for f in np.unique(fold):
        rows = fold == f
        parts = [w * B[rows] for w, B in zip(weights, joints, strict=True)]
        slopes = [B.T @ (w * responses[rows, j]) for j, (w, B) in enumerate(zip(weights, parts, strict=True))]
        sums[f] = rows, np.sum([B.T @ B for B in parts], axis=0), np.sum(slopes, axis=0)
    total = np.sum([slope for _, _, slope in sums.values()], axis=0)
    for f, (rows, inner, slope) in sums.items():
        left_out = (0.0, 0.0) if f == OUTSIDE else (inner, slope)
        x = pseudo_inverse(hypothesis.fit.normal - left_out[0]) @ (total - left_out[1])
        residual[rows] = responses[rows] - np.stack([B[rows] @ x for B in joints], axis=1)
    return residual


def _windows(J: Array, residual: Array, label: NDArray[np.intp]) -> Array:
    """Gain (W, n, S) of each joint in each window, by the force fitted to all other joints."""
    W, n = label[-1] + 1, residual.shape[1]
    edges = np.searchsorted(label, np.arange(W + 1))
    A, b = np.zeros((W, n, 3, 3)), np.zeros((W, n, 3, residual.shape[2]))
    for w in range(W):
        rows = slice(edges[w], edges[w + 1])
        A[w] = np.einsum("mij,mkj->jik", J[rows], J[rows])
        b[w] = np.einsum("mij,mjs->jis", J[rows], residual[rows])
    others = A.sum(axis=1, keepdims=True) - A + STIFF * np.eye(3)
    force = np.linalg.solve(others, b.sum(axis=1, keepdims=True) - b)
    return 2 * np.einsum("wjis,wjis->wjs", force, b) - np.einsum("wjis,wjis->wjs", force, A @ force)


def _intervals(gain: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First and last + 1 window (S,) of the run with the largest sum of gains (W, S)."""
    W, S = gain.shape
    sums = np.concatenate([np.zeros((1, S)), np.cumsum(gain, axis=0)])
    best, first, last = np.full(S, -np.inf), np.zeros(S, dtype=np.intp), np.zeros(S, dtype=np.intp)
    for length in range(1, max(2, int(LONGEST * W) + 1)):
        runs = sums[length:] - sums[:-length]
        top = np.argmax(runs, axis=0)
        value = runs[top, np.arange(S)]
        better = value > best
        best, first, last = (
            np.where(better, value, best),
            np.where(better, top, first),
            np.where(better, top + length, last),
        )
    return first, last
