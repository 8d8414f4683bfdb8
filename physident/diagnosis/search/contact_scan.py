"""Contact: a force on the tool that no other recording predicts, so each joint is tested by the force fitted to the others.

In each window of half a second, the force is fitted to all joints but one and scored on the remaining joint, which feels it
through its own row of the Jacobian. An interval is the run of windows, at most half a recording, with the largest
sum of gains without its strongest joint.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import STIFF, Candidate, Option
from physident.diagnosis.problem.search_data import OUTSIDE, rows_of
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.baseline_products import response_products
from physident.diagnosis.statistics.left_out_gains import evidence_of
from physident.diagnosis.statistics.left_out_residuals import reduction_percent
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.diagnosis.statistics.thresholds import MIN_REDUCTION_PERCENT
from physident.effects.contact import PIECE, Contact
from physident.large_arrays import blocks

Array = NDArray[np.float64]
PHASES = (0.0, PIECE / 2)  # s: where windows begin; an edge is then at most an eighth of a second off
LONGEST = 0.5  # of a recording: what lasts longer is no passing contact but a change of the arm
EDGE = 1.05  # times a length is the next one that is tried: the ends are moved to where they fit best
WINDOWS = 1 << 22  # numbers of responses in windows that are worked on at once
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

    @property
    def is_of_use(self) -> bool:
        """Whether the best contact could be accepted by some threshold: it is worth naming, and not the evidence of one joint alone."""
        useful = min(self.reduction, self.joint_reduction) >= MIN_REDUCTION_PERCENT
        return bool(useful and self.evidence_without_best_joint[0] > 0)


def scan_contacts(hypothesis: Hypothesis, responses: Array, slopes: Array | None = None) -> ContactScan:
    """The best contact for each of some responses (M, n, S) beside a hypothesis' baseline.

    ``slopes`` (F, n, R, S) are the products of the baseline with the responses over each fold, where they are known.
    """
    fit, regressor = hypothesis.fit, hypothesis.data.regressor
    residual = _residual(hypothesis, responses, slopes)
    weights = contact_weights(hypothesis)
    residual *= weights[:, None]
    before = np.stack([np.einsum("ms,ms->s", part, part) for part in residual.transpose(1, 0, 2)])
    before += (weights**2 * hypothesis.problem.taken_off_squares)[:, None]
    best, gain = np.full(residual.shape[2], -np.inf), np.zeros(before.shape)
    effect, windows, reduction = Contact(), np.zeros((0, len(fit.weights))), 0.0
    J = hypothesis.problem.jacobians
    for index, signals in enumerate(hypothesis.problem.signals):
        rows = rows_of(regressor.recording, index)
        time = regressor.time[rows] - signals.origin
        for phase in PHASES:
            start, label = _labels(time, phase)
            from_first = slice(rows.start + int(np.searchsorted(label, 0)), rows.stop)
            gains_of_windows = _windows(J[from_first] * weights, residual[from_first], label[label >= 0])
            first, last, found = most_without_the_strongest(gains_of_windows)
            value = found.sum(axis=0) - found.max(axis=0)
            better = value > best
            best, gain = np.where(better, value, best), np.where(better, found, gain)
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


def strongest_run(J: Array, residual: Array, time: Array) -> float:
    """What the best run of windows explains of one recording's residual (M, n) without its strongest joint, by the Jacobian ``J`` (M, 3, n)
    of its rows at ``time`` (M,) [s], both in units of the noise."""
    best = 0.0
    for phase in PHASES:
        _, label = _labels(time, phase)
        inside = label >= 0
        if inside.any():
            gains = _windows(J[inside], residual[inside][:, :, None], label[inside])
            found = most_without_the_strongest(gains)[2]
            best = max(best, float(found.sum() - found.max()))
    return best


def _labels(time: Array, phase: float) -> tuple[float, NDArray[np.intp]]:
    """When the first window of a phase begins [s], and the window of each row (M,), negative before it."""
    start = float(np.floor(time[0] / PIECE) * PIECE + phase)
    return start, np.floor((time - start) / PIECE).astype(np.intp)


def contact_weights(hypothesis: Hypothesis) -> Array:
    """The weights (n,) of the joints' rows: those of the fit, less where the model's error was taken off.

    Who pushes the forearm is felt by the wrist less than by a push at the tool: beside the error of a model that does not matter, beside the noise
    of a comparison it would refute every contact.
    """
    fit, problem = hypothesis.fit, hypothesis.problem
    usual = problem.taken_off_squares / np.maximum(problem.regressor.counted.sum(axis=0), 1)
    return fit.weights * fit.sigma / np.sqrt(fit.sigma**2 + usual)


def _residual(hypothesis: Hypothesis, responses: Array, slopes: Array | None) -> Array:
    """What the baseline leaves of responses (M, n, S) in each fold when it is fitted to the others; in gaps, to all.

    A contact lies inside a fold: a baseline that was fitted to its rows would have taken a part of it.
    """
    squares, products = hypothesis.fit.weights**2, hypothesis.products
    own = products.own
    slopes = response_products(products, responses).By if slopes is None else slopes
    weighted, inner = np.tensordot(squares, slopes, (0, 1)), np.tensordot(squares, products.BB, (0, 1))
    total, x = weighted.sum(axis=0), []
    for label, BB, slope in zip(own.labels, inner, weighted, strict=True):
        left_out = (0.0, 0.0) if label == OUTSIDE else (BB, slope)
        x.append(pseudo_inverse(hypothesis.fit.normal - left_out[0]) @ (total - left_out[1]))
    residual = np.empty_like(responses)
    for part in own.each_part():
        torque = hypothesis.baseline.some_torque(part.rows, x[own.index[part.fold]])
        np.subtract(responses[part.rows], torque, out=residual[part.rows])
    return residual


def _windows(J: Array, residual: Array, label: NDArray[np.intp]) -> Array:
    """Gain (W, n, S) of each joint in each window, by the force fitted to all other joints."""
    W, n, S = label[-1] + 1, residual.shape[1], residual.shape[2]
    edges = np.searchsorted(label, np.arange(W + 1))
    gain = np.zeros((W, n, S))
    longest = int(np.diff(edges).max())
    for some in blocks(W, max(1, WINDOWS // (longest * n * S))):
        first, last = edges[some.start], edges[some.stop]
        # windows as rows of equal length, filled up with zeros
        if first == last:
            continue
        at = edges[some][:, None] + np.arange(longest)
        inside = at < edges[some.start + 1 : some.stop + 1][:, None]
        at = np.where(inside, at, first) - first
        A = (J[first:last][at] * inside[:, :, None, None]).transpose(0, 3, 2, 1)  # (w, n, 3, rows)
        b = A @ residual[first:last][at].transpose(0, 2, 1, 3)
        A = A @ A.transpose(0, 1, 3, 2)
        others = A.sum(axis=1, keepdims=True) - A + STIFF * np.eye(3)
        force = np.linalg.solve(others, b.sum(axis=1, keepdims=True) - b)
        gain[some] = np.sum(force * (2 * b - A @ force), axis=2)
    return gain


def most_without_the_strongest(gain: Array) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """First and last + 1 window (S,) of the run that explains most without its strongest joint, and its gains (n, S).

    ``gain`` (W, n, S). The run of the largest sum over all joints may end with what one joint alone makes much of, and would
    then be refused. Of equal runs it is the shortest and first; long ones are tried to a twentieth of their length.
    """
    (W, n, S), every = gain.shape, np.arange(gain.shape[2])
    sums = np.concatenate([np.zeros((1, n, S)), np.cumsum(gain, axis=0)])
    best, first, last = np.full(S, -np.inf), np.zeros(S, dtype=np.intp), np.zeros(S, dtype=np.intp)
    for length in _lengths(max(1, int(LONGEST * W))):
        runs = sums[length:] - sums[:-length]
        value = runs.sum(axis=1) - runs.max(axis=1)
        at = value.argmax(axis=0)
        better = value[at, every] > best
        best, first = np.where(better, value[at, every], best), np.where(better, at, first)
        last = np.where(better, at + length, last)
    return first, last, (sums[last, :, every] - sums[first, :, every]).T


def _lengths(longest: int) -> list[int]:
    """Every number of windows up to twenty seconds; then each a twentieth more than the one before."""
    lengths = [1]
    while lengths[-1] < longest:
        lengths.append(max(lengths[-1] + 1, int(EDGE * lengths[-1])))
    return [*lengths[:-1], longest]
