"""Surrogates keep what noise is - its spectrum, the joints' correlation - and lose what ties it to the motion."""

from __future__ import annotations

import numpy as np
import pytest

from physident.diagnosis.statistics.surrogates import phase_randomised


@pytest.fixture
def residual() -> np.ndarray:
    rng = np.random.default_rng(3)
    slow = np.cumsum(rng.standard_normal((500, 2)), axis=0)
    slow -= np.linspace(0, 1, 500)[:, None] * (slow[-1] - slow[0])
    return np.column_stack([slow[:, 0], 0.5 * slow[:, 0] + slow[:, 1]])


def test_power_and_cross_power_at_every_frequency_are_kept(residual: np.ndarray) -> None:
    segment = np.repeat([0, 1], [301, 199])
    made = phase_randomised(residual, segment, 5, seed=1)
    for part in (0, 1):
        true = np.fft.rfft(residual[segment == part], axis=0)[1:]
        for s in range(5):
            found = np.fft.rfft(made[segment == part][:, :, s], axis=0)[1:]
            np.testing.assert_allclose(np.abs(found), np.abs(true), rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(
                found[:, 0] * found[:, 1].conj(), true[:, 0] * true[:, 1].conj(), rtol=1e-8, atol=1e-8
            )


def test_the_relation_to_the_original_is_gone_and_means_are_of_the_size_of_slow_noise(residual: np.ndarray) -> None:
    made = phase_randomised(residual + 1e3, np.zeros(500, dtype=int), 400, seed=2)
    assert np.abs(made.mean(axis=0)).max() < 100  # a constant is no noise
    left = residual - residual.mean(axis=0)
    along = np.einsum("mj,mjs->js", left, made) / np.sum(left**2, axis=0)[:, None]
    assert np.abs(along.mean(axis=1)).max() < 4 * along.std() / np.sqrt(400)


def test_the_same_seed_draws_the_same(residual: np.ndarray) -> None:
    segment = np.zeros(500, dtype=int)
    assert (phase_randomised(residual, segment, 3, 5) == phase_randomised(residual, segment, 3, 5)).all()
    assert not np.allclose(phase_randomised(residual, segment, 3, 5), phase_randomised(residual, segment, 3, 6))
