"""Left-out gains against plain refits of the stacked rows, one split at a time."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from physident.diagnosis.problem.baseline_fit import fit_baseline
from physident.diagnosis.problem.candidates import Candidate, Option
from physident.diagnosis.problem.folds import blocks, split_into_folds
from physident.diagnosis.problem.search_data import OUTSIDE, Baseline, SearchData
from physident.diagnosis.statistics.left_out_gains import left_out_gains
from physident.diagnosis.statistics.left_out_residuals import LeftOutFits, block_costs
from physident.dynamics.regressor import JointRows, Regressor
from physident.effects.effect import Column

M, N = 240, 2
OPTIONS = (
    (0,),
    (1,),
    (2, 3),
    (4,),
)  # columns of the candidates: a shape of two, one of two columns, one in both joints
ROWS = ((0, 1, 4), (2, 3, 4))  # which joint has which columns


def made(prior: float) -> tuple[SearchData, Baseline]:
    rng = np.random.default_rng(8)
    base = tuple(rng.standard_normal((M, 5)) for _ in range(N))
    joints = tuple(JointRows(np.array(own), rng.standard_normal((M, len(own)))) for own in ROWS)
    torque = np.column_stack([rows.values.sum(axis=1) for rows in joints]) + 0.3 * rng.standard_normal((M, N))
    columns = tuple(Column(f"c{i}", "1", 1, "test") for i in range(5))
    zero = np.zeros(M, dtype=int)
    regressor = Regressor(columns, joints, torque, np.arange(M) / 20, zero, zero, 20.0, np.ones((M, N), dtype=bool))
    candidates = (
        Candidate("shaped", (1,), (Option(None, (0,)), Option(None, (1,)))),
        Candidate("double", (2,), (Option(None, (2, 3)),)),
        Candidate("both", (), (Option(None, (4,)),)),
    )
    fold = np.repeat([0, 1, 2, 3], 60)
    fold[[60, 61, 120, 180]] = OUTSIDE
    return SearchData(
        regressor=regressor, candidates=candidates, response=torque, fold=fold, memory=np.ones(N)
    ), Baseline(base, np.full(5, prior))


def stacked(evidence: SearchData, baseline: Baseline, weights: np.ndarray, columns: tuple[int, ...]) -> np.ndarray:
    """Rows (M, n, 5 + k) of the baseline and some columns, in units of the noise."""
    rows = []
    for j in range(N):
        rows.append(weights[j] * np.column_stack([baseline.joints[j], evidence.joint_columns(j, columns)]))
    return np.stack(rows, axis=1)


def refitted(evidence: SearchData, baseline: Baseline, weights: np.ndarray, columns: tuple[int, ...], f: int) -> tuple:
    """Cost on the other folds and costs (n,) on fold f of a plain least-squares fit on the other folds."""
    A, y = stacked(evidence, baseline, weights, columns), evidence.response * weights
    train, test = (evidence.fold != f) & (evidence.fold != OUTSIDE), evidence.fold == f
    pulls = np.diag(np.sqrt(np.append(baseline.prior, np.zeros(len(columns)))))[:5]
    rows = np.concatenate([A[train].reshape(-1, A.shape[2]), pulls])
    x = np.linalg.lstsq(rows, np.append(y[train].ravel(), np.zeros(5)), rcond=None)[0]
    left = rows @ x - np.append(y[train].ravel(), np.zeros(5))
    return float(left @ left), np.sum((y[test] - A[test] @ x) ** 2, axis=0)


@pytest.mark.parametrize("prior", [0.0, 50.0])
def test_gains_are_those_of_refits_with_the_shape_chosen_outside_the_fold(prior: float) -> None:
    evidence, baseline = made(prior)
    now = fit_baseline(evidence, baseline)
    found = left_out_gains(evidence, baseline, now, evidence.response[:, :, None])
    for f in range(4):
        _, before = refitted(evidence, baseline, now.weights, (), f)
        np.testing.assert_allclose(found.before[f, :, 0], before, rtol=1e-8)
        for c, candidate in enumerate(evidence.candidates):
            fits = [refitted(evidence, baseline, now.weights, o.columns, f) for o in candidate.options]
            after = min(fits, key=lambda one: one[0])[1]
            np.testing.assert_allclose(found.gain[c, f, :, 0], before - after, rtol=1e-7, atol=1e-7)


def test_costs_of_blocks_are_those_of_refits_and_add_up_to_the_gains() -> None:
    evidence, baseline = made(2.0)
    now = fit_baseline(evidence, baseline)
    found = left_out_gains(evidence, baseline, now, evidence.response[:, :, None])
    fits, labels = LeftOutFits(evidence, baseline, now.weights), blocks(evidence, 1.0)
    alone = now.weights**2 * fits.squares_of_blocks()
    np.testing.assert_allclose(alone, block_costs(fits.residual(), now.weights, labels), rtol=1e-8)
    for c, candidate in enumerate(evidence.candidates):
        options = [option.columns for option in candidate.options]
        after = now.weights**2 * fits.squares_of_blocks(options, np.zeros((len(options), len(options[0]))))
        if len(options) == 1:
            effect = evidence.columns(options[0])
            same = now.weights**2 * fits.squares_of_blocks(effect, np.zeros(effect.count))
            np.testing.assert_allclose(after, same, rtol=1e-8)
        np.testing.assert_allclose(
            (alone - after).sum(axis=0), found.gain[c, :, :, 0].sum(axis=0), rtol=1e-7, atol=1e-7
        )
        for f in range(4):
            plain = min((refitted(evidence, baseline, now.weights, o, f) for o in options), key=lambda one: one[0])[1]
            mine = np.unique(labels[evidence.fold == f])
            np.testing.assert_allclose(after[mine].sum(axis=0), plain, rtol=1e-8)


def test_a_column_of_the_baseline_has_no_share_and_one_across_it_has_all() -> None:
    evidence, baseline = made(0.0)
    inside = Baseline((np.column_stack([baseline.joints[0], evidence.joint_columns(0, (0,))]),
                       np.column_stack([baseline.joints[1], evidence.joint_columns(1, (0,))])), np.zeros(6))  # fmt: skip
    one = replace(evidence, candidates=(Candidate("own", (1,), (Option(None, (0,)),)),))
    response = evidence.response[:, :, None]
    for beside, share in ((inside, 0.0), (Baseline((np.zeros((M, 1)),) * 2, np.ones(1)), 1.0)):
        found = left_out_gains(one, beside, fit_baseline(one, beside), response)
        assert found.visible[0] == pytest.approx(share, abs=1e-10)


def test_folds_are_recordings_from_four_on_else_blocks_with_gaps() -> None:
    evidence, baseline = made(0.0)
    now = fit_baseline(evidence, baseline)
    labels = split_into_folds(evidence, baseline, now, 3.0, 1, seed=0)
    assert set(labels) >= {OUTSIDE, 0, 1, 2, 3}
    for a, b in itertools.pairwise(labels):
        assert a == b or OUTSIDE in (a, b)  # blocks never touch
    recording = np.repeat(np.arange(5), 48)
    several = replace(evidence, regressor=replace(evidence.regressor, recording=recording))
    assert (split_into_folds(several, baseline, now, 3.0, 5, seed=0) == recording).all()


def test_a_recording_that_shows_what_no_other_does_is_no_fold() -> None:
    """One parameter is excited by the last of five recordings alone: left out, it would be judged by a guess."""
    evidence, baseline = made(0.0)
    recording = np.repeat(np.arange(5), 48)
    several = replace(evidence, regressor=replace(evidence.regressor, recording=recording))
    alone = tuple(
        B * np.where((np.arange(B.shape[1]) == 0) & (recording[:, None] < 4), 1e-4, 1.0) for B in baseline.joints
    )
    one = Baseline(alone, baseline.prior)
    labels = split_into_folds(several, one, fit_baseline(several, one), 3.0, 5, seed=0)
    assert (labels != recording).any()
    assert len(np.unique(labels[recording == 4])) > 1


def test_the_evidence_of_pure_noise_stays_small_and_that_of_the_truth_is_a_likelihood_ratio() -> None:
    evidence, baseline = made(0.0)
    now = fit_baseline(evidence, baseline)
    noise = np.random.default_rng(4).standard_normal((M, N, 200))
    found = left_out_gains(
        evidence, baseline, now, np.concatenate([evidence.response[:, :, None], noise], axis=2)
    ).evidence
    assert np.median(found[:, 1:]) < 1.0  # overfitting costs on left-out rows
    assert found[1, 0] > found[1, 1:].max()
