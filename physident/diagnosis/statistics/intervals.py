"""Intervals of a diagnosis: jackknives over blocks, joints and recordings for values, a bootstrap over blocks for gains."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.search.hypothesis import AcceptedEffect, Hypothesis
from physident.diagnosis.statistics.baseline_products import BaselineProducts
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.estimation.uncertainty import t_quantile

Array = NDArray[np.float64]
RESAMPLES = 1000  # the ends of a 95 % interval then wander by a few per cent of its width
FEWEST_JOINTS = 3  # that can each be left out: how far two move a value says little about how far a third would
FEWEST_RECORDINGS = 2  # of a user, who has no more: Student's t of one degree of freedom says how little two tell
BY_OTHERS = 2.0  # times a value's error at most that the others alone know it by: where one joint or recording decides, none disagrees with it
SURE = 0.975  # of the distribution: 95 % to both sides
STEP = 0.02  # relative, of a shape: its column's derivative is then right to a part in a thousand


@dataclass(frozen=True, eq=False)
class Spread:
    """How far values (P,) may be from what they were found to be: their ``covariance`` (P, P) from so many ``blocks``, and what is said of them
    without each of the ``joints`` and of the ``recordings``."""

    covariance: Array
    blocks: int
    joints: WithoutEach
    recordings: WithoutEach

    @property
    def half(self) -> float:
        """How many standard errors a 95 % interval reaches."""
        return t_quantile(self.blocks)

    def errors(self, rows: Array) -> Array:
        """Standard errors (r,) of linear functions of the values, ``rows`` (r, P), by blocks of time."""
        return np.sqrt(np.maximum(np.einsum("rk,kl,rl->r", rows, self.covariance, rows), 0.0))

    def reach(self, rows: Array, several: bool) -> Array:
        """How far the 95 % intervals of linear functions of the values, ``rows`` (r, P), reach to either side (r,): errors are those that
        blocks of time show, and those by which recordings and, of values that act on ``several`` joints, joints disagree beyond these."""
        from scipy.stats import t

        of_blocks = self.errors(rows) ** 2
        each = [(of_blocks, self.blocks), self.recordings.variances(rows, of_blocks, FEWEST_RECORDINGS)]
        each += [self.joints.variances(rows, of_blocks, FEWEST_JOINTS)] if several else []
        total = np.sum([variance for variance, _ in each], axis=0)
        shares = [variance / np.maximum(total, 1e-300) for variance, _ in each]
        # degrees of freedom of a sum of variances (Welch, 1947)
        of_each = np.sum(
            [one**2 / np.maximum(count - 1, 1) for one, (_, count) in zip(shares, each, strict=True)], axis=0
        )
        # values that nothing moves, as of exact recordings, have no width of any shape
        return t.ppf(SURE, 1 / np.clip(of_each, 1e-9, 1.0)) * np.sqrt(total)


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """How far the extended model's ``theta`` (P,) and the ``changes`` of all accepted effects, one after the other (E,), may be from the truth, and
    ``shape_errors`` [the effect's key, standard error of its shape].

    A change is known better than the value from before and that from after: what the model may hold instead, it held before, too.
    """

    theta: Spread
    changes: Spread
    shape_errors: dict[tuple[str, tuple[int, ...]], float]

    @property
    def half(self) -> float:
        """How many standard errors a 95 % interval reaches."""
        return self.theta.half


@dataclass(frozen=True, eq=False)
class WithoutEach:
    """By how much values move, ``moved`` (n, P), where the rows of one joint, or of one recording, are left out, and its covariance then
    (n, P, P) and ``with_all`` (P, P), in units of the noise.

    A model errs on a joint from one end of a recording to the other, by its gain or its friction, and along one motion otherwise than
    along another: blocks of time move together then, and only the other joints, or recordings, contradict what this one says of a load.
    """

    moved: Array
    covariance: Array
    with_all: Array

    @classmethod
    def of(cls, normals: Array, scores: Array, normal: Array, J: Array) -> WithoutEach:
        """Of parts whose normal matrices are ``normals`` (n, p, p) of the whole ``normal`` (p, p), and whose residuals pull by ``scores`` (n, p), for
        values that move with the fit's by ``J`` (P, p)."""
        without = [pseudo_inverse(normal - one) for one in normals]
        moved = np.array([J @ one @ score for one, score in zip(without, scores, strict=True)])
        return cls(moved, np.array([J @ one @ J.T for one in without]), J @ pseudo_inverse(normal) @ J.T)

    def variances(self, rows: Array, of_blocks: Array, fewest: int) -> tuple[Array, NDArray[np.intp]]:
        """The variance (r,) of linear functions of the values, ``rows`` (r, P), between parts, beyond what their variance over blocks (r,) makes of
        it, zero of less than ``fewest``; and of how many parts (r,) it is, those that the others can do without. A jackknife, whose moves
        are by noise alone as large as the variance grows without the part: Hausman, "Specification tests in econometrics" (1978)."""
        moved = self.moved @ rows.T
        alone = np.einsum("rk,jkl,rl->jr", rows, self.covariance, rows)
        known = np.maximum(np.einsum("rk,kl,rl->r", rows, self.with_all, rows), 1e-300)
        counted = (alone <= BY_OTHERS**2 * known) & (moved != 0)
        count = counted.sum(axis=0)
        by_noise = np.maximum(alone / known - 1, 0.0) * of_blocks
        beyond = np.sum(counted * (moved**2 - by_noise), axis=0) * (count - 1) / np.maximum(count, 1)
        return np.where(count >= fewest, np.maximum(beyond, 0.0), 0.0), count


def uncertainty_of(hypothesis: Hypothesis, wander: Columns | None = None) -> Uncertainty:
    """Errors of all values and shapes, from how far they move when one block is left out (CV3, see ``uncertainty``), and from torques that
    ``wander`` by one standard deviation each from day to day, along whole recordings, which no block tells."""
    baseline, shaped = hypothesis.baseline, []
    for a, values in zip(hypothesis.accepted, hypothesis.effect_values, strict=True):
        slopes = _slope(hypothesis, a, values)
        if slopes is not None:
            shaped.append(a.candidate.key)
            baseline = baseline.joined(slopes)
    products, squares = BaselineProducts(hypothesis.data, baseline), hypothesis.fit.weights**2
    own, R = products.own, len(hypothesis.fit.x)
    G, n, every = len(own.blocks), len(squares), len(baseline.prior)
    normals, scores = np.zeros((G, every, every)), np.zeros((G, every))
    of_joints = np.zeros((n, every, every)), np.zeros((n, every))
    recording = own.recording_of_unit[own.blocks]
    for j, (joint, square) in enumerate(zip(products.units, squares, strict=True)):
        part = square * joint.products[own.blocks]
        known = joint.places < R
        slope = part[:, :-1, -1] - part[:, :-1, :-1][:, :, known] @ hypothesis.fit.x[joint.places[known]]
        normals[:, joint.places[:, None], joint.places] += part[:, :-1, :-1]
        scores[:, joint.places] += slope
        of_joints[0][j][np.ix_(joint.places, joint.places)] = part[:, :-1, :-1].sum(axis=0)
        of_joints[1][j, joint.places] = slope.sum(axis=0)
    prior = np.diag(baseline.prior)
    H = normals.sum(axis=0) + prior
    moved = np.array([pseudo_inverse(H - normal) @ score for normal, score in zip(normals, scores, strict=True)])
    inverse = pseudo_inverse(H)
    covariance = moved.T @ moved * (G - 1) / G + inverse @ prior @ inverse
    if wander is not None:
        # of all rows, those between blocks as well
        whole = np.tensordot(squares, products.equations.squares, 1) + prior
        pulled = pseudo_inverse(whole) @ np.tensordot(squares, products.with_columns(wander)[1], 1)
        covariance += pulled @ pulled.T
    R = len(hypothesis.fit.x)
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))[R:]
    shapes = {
        key: float(error * getattr(a.effect, str(_field(a)))[0])
        for key, error in zip(shaped, errors, strict=True)
        for a in hypothesis.accepted
        if a.candidate.key == key
    }
    each = [recording == one for one in np.unique(recording)]
    of_recordings = (
        np.array([normals[one].sum(axis=0) for one in each]),
        np.array([scores[one].sum(axis=0) for one in each]),
    )

    def spread(J: Array) -> Spread:
        """That of values that move with those of the fit by ``J`` (P, R)."""
        wide = np.column_stack([J, np.zeros((len(J), every - R))])
        joints, recordings = (WithoutEach.of(*parts, H, wide) for parts in (of_joints, of_recordings))
        return Spread(J @ covariance[:R, :R] @ J.T, G, joints, recordings)

    return Uncertainty(spread(hypothesis.jacobian), spread(hypothesis.jacobian_of_changes), shapes)


def resampled_reduction(before: Array, after: Array, seed: int) -> tuple[float, float]:
    """95 % interval of 100 (1 - RMS after / RMS before) from squared residuals (G,) of blocks."""
    draws = np.random.default_rng([seed, 13]).integers(0, len(before), (RESAMPLES, len(before)))
    ratio = np.sqrt(after[draws].sum(axis=1) / np.maximum(before[draws].sum(axis=1), 1e-300))
    low, high = np.quantile(100 * (1 - ratio), (0.025, 0.975))
    return float(low), float(high)


def _field(accepted: AcceptedEffect) -> str | None:
    """The field of the shape that was searched for, or None."""
    if len(accepted.candidate.options) == 1:
        return None
    for shape in accepted.effect.shape_parameters:
        if getattr(accepted.effect, shape.field) is not None and not shape.discrete:
            return shape.field
    return None


def _slope(hypothesis: Hypothesis, accepted: AcceptedEffect, values: Array) -> Columns | None:
    """How the effect's torque (M, 1) in each joint's rows moves with the logarithm of its shape."""
    field = _field(accepted)
    if field is None:
        return None
    value = getattr(accepted.effect, field)[0]
    up, down = [
        hypothesis.problem.fresh_columns(replace(accepted.effect, **{field: (value * factor,)}), hypothesis.model)
        for factor in (1 + STEP, 1 / (1 + STEP))
    ]
    slope = (up.torque(values) - down.torque(values)) / (2 * np.log(1 + STEP))
    return Columns.of([column[:, None] for column in slope.T])
