"""Contact: a force on the tool that no other recording predicts, so that joints judge each other instead.

In each window of half a second the force is fitted on all joints but one and judged on that one, which sees it through its
own row of the Jacobian. An interval is the run of windows, at most half a recording, with the largest sum.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import Candidate, Option
from physident.diagnosis.problem.evidence import OUTSIDE
from physident.diagnosis.search.hypothesis import STIFF, State
from physident.diagnosis.search.shape_refinement import Judge
from physident.diagnosis.statistics.left_out_gains import evidence_of
from physident.diagnosis.statistics.left_out_residuals import reduced
from physident.diagnosis.statistics.normal_equations import inverted
from physident.effects.contact import PIECE, Contact, tool_jacobian

Array = NDArray[np.float64]
PHASES = (0.0, PIECE / 2)  # s: where windows begin; an edge is then at most an eighth of a second off
EDGES = np.arange(-5, 6) * 0.05  # s: by which a found start is moved to fit best
STEADY = (
    np.arange(-10, 11) * 0.1,
    np.arange(-5, 6) * 0.01,
)  # s: by which both ends of a steady push are, coarsely, finely
LONGEST = 0.5  # of a recording: what lasts longer is no passing contact but a change of the arm
CONTACT = Candidate("contact", (), (Option(None, ()),))


@dataclass(frozen=True, eq=False)
class Scan:
    """The best interval for each response: its ``evidence`` (S,), and the ``least`` (S,) of it without the joint that speaks
    most for it; for the first response its ``effect``, ``windows`` (W, n), the gains of its pieces, the ``reduction`` [%]
    of RMS over all joints of its own recording, and ``felt``, that of the joint that feels it most over all recordings."""

    evidence: Array
    least: Array
    effect: Contact
    windows: Array
    reduction: float
    felt: float


def scan(state: State, responses: Array) -> Scan:
    """The best contact for each of some responses (M, n, S) beside a state's baseline."""
    now, regressor = state.fit, state.evidence.regressor
    residual = _residual(state, responses) * now.weights[:, None]
    before = np.einsum("mjs,mjs->js", residual, residual)
    best, gain = np.full(residual.shape[2], -np.inf), np.zeros(before.shape)
    effect, windows, reduction = Contact(), np.zeros((0, len(now.weights))), 0.0
    for index, signals in enumerate(state.case.signals):
        rows = regressor.recording == index
        time = regressor.time[rows] - signals.origin
        at = np.clip(np.searchsorted(signals.time, regressor.time[rows]), 0, len(signals.time) - 1)
        J = tool_jacobian(state.case.model.robot, signals.q[at]) * now.weights
        J = J * (state.case.weights * regressor.counted)[rows][:, None, :]
        for phase in PHASES:
            start = np.floor(time[0] / PIECE) * PIECE + phase
            label = np.floor((time - start) / PIECE).astype(int)
            judged = _windows(J[label >= 0], residual[rows][label >= 0], label[label >= 0])
            first, last = _intervals(judged.sum(axis=1))
            sums = np.concatenate([np.zeros((1, *judged.shape[1:])), np.cumsum(judged, axis=0)])
            every = np.arange(residual.shape[2])
            own = sums[last, :, every].T - sums[first, :, every].T
            better = own.sum(axis=0) > best
            best, gain = np.where(better, own.sum(axis=0), best), np.where(better, own, gain)
            if better[0]:
                ends = (float(start + first[0] * PIECE), float(start + last[0] * PIECE))
                effect, windows = (
                    Contact(intervals=(ends,), recording=signals.recording),
                    judged[first[0] : last[0], :, 0],
                )
                left = 1 - float(own[:, 0].sum()) / max(float(np.sum(residual[rows][:, :, 0] ** 2)), 1e-300)
                reduction = 100 * (1 - float(np.sqrt(max(left, 0.0))))
    worth = regressor.counted.sum(axis=0) / now.memory
    each = np.array([evidence_of(before[[j]], gain[[j]], worth[[j]]) for j in range(len(worth))])
    felt = reduced(before[:, 0], before[:, 0] - gain[:, 0])
    return Scan(each.sum(axis=0), each.sum(axis=0) - each.max(axis=0), effect, windows, reduction, felt)


def placed(state: State, effect: Contact) -> Contact:
    """The contact with its start and number of pieces where its forces explain most for their number (Schwarz, 1978); with
    one force for each push where that is enough."""
    after = state.also(CONTACT, effect).fit  # sized by what the contact leaves, not by what it makes
    judge, ((start, end),) = Judge(state, after.weights), effect.intervals
    worth = float((len(state.evidence.fold) / after.memory).sum())
    pieces = max(1, round((end - start) / PIECE))
    begin = max(0.0, start)

    def value(one: Contact) -> float:
        forces = 3 * len(one.pieces())
        return judge.gain(state.case.columns(one, state.model)) - forces * float(np.log(worth))

    def made(first: float, count: int) -> Contact:
        return Contact(intervals=((first, first + count * PIECE),), recording=effect.recording)

    counts = range(max(1, pieces - 2), pieces + 3)
    best = max((made(begin + d, k) for k in counts for d in (-PIECE, 0.0, PIECE) if begin + d >= 0), key=value)
    ((begin, end),) = best.intervals
    count = len(best.pieces())
    best = max((made(begin + d, count) for d in EDGES if begin + d >= 0), key=value)
    best = _worthwhile(best, judge, state.case.columns(best, state.model), 3 * float(np.log(worth)))
    steady = _trued(replace(best, steady=True), value)
    return steady if value(steady) > value(best) else best


def _trued(effect: Contact, value: Callable[[Contact], float]) -> Contact:
    """A steady contact with the ends of its intervals where they fit best, one after the other."""
    for steps in STEADY:
        for k, end in itertools.product(range(len(effect.intervals)), (0, 1)):
            every = []
            for step in steps:
                edges = np.array(effect.intervals)
                edges[k, end] = max(0.0, round(edges[k, end] + step, 3))
                if (np.diff(edges.ravel()) > 0).all():
                    every.append(replace(effect, intervals=tuple(map(tuple, edges.tolist()))))
            effect = max(every, key=value)
    return effect


def _worthwhile(effect: Contact, judge: Judge, columns: Sequence[Array], price: float) -> Contact:
    """The contact without the pieces, pauses between two pushes, whose force explains less than its ``price``."""
    pieces, whole = effect.pieces(), judge.gain(columns)
    kept = [
        piece
        for k, piece in enumerate(pieces)
        if len(pieces) == 1
        or whole - judge.gain([np.delete(c, np.s_[3 * k : 3 * k + 3], axis=1) for c in columns]) > price
    ]
    merged: list[tuple[float, float]] = []
    for start, end in kept:
        if merged and start - merged[-1][1] < 1e-6:
            merged[-1] = (merged[-1][0], end)
        else:
            merged.append((start, end))
    return Contact(intervals=tuple(merged), recording=effect.recording) if merged else effect


def _residual(state: State, responses: Array) -> Array:
    """What the baseline leaves of responses (M, n, S) in each fold when it is fitted to the others; in gaps, to all.

    A contact lies inside a fold: a baseline that was fitted to its rows would have taken a part of it.
    """
    weights, joints, fold = state.fit.weights, state.baseline.joints, state.evidence.fold
    residual, sums = np.empty_like(responses), {}
    for f in np.unique(fold):
        rows = fold == f
        parts = [w * B[rows] for w, B in zip(weights, joints, strict=True)]
        slopes = [B.T @ (w * responses[rows, j]) for j, (w, B) in enumerate(zip(weights, parts, strict=True))]
        sums[f] = rows, np.sum([B.T @ B for B in parts], axis=0), np.sum(slopes, axis=0)
    total = np.sum([slope for _, _, slope in sums.values()], axis=0)
    for f, (rows, inner, slope) in sums.items():
        left_out = (0.0, 0.0) if f == OUTSIDE else (inner, slope)
        x = inverted(state.fit.normal - left_out[0]) @ (total - left_out[1])
        residual[rows] = responses[rows] - np.stack([B[rows] @ x for B in joints], axis=1)
    return residual


def _windows(J: Array, residual: Array, label: NDArray[np.intp]) -> Array:
    """Gain (W, n, S) of each joint in each window by the force that all other joints tell."""
    W, n = label[-1] + 1, residual.shape[1]
    edges = np.searchsorted(label, np.arange(W + 1))
    A, b = np.zeros((W, n, 3, 3)), np.zeros((W, n, 3, residual.shape[2]))
    for w in range(W):
        own = slice(edges[w], edges[w + 1])
        A[w] = np.einsum("mij,mkj->jik", J[own], J[own])
        b[w] = np.einsum("mij,mjs->jis", J[own], residual[own])
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
