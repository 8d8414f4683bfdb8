"""The share of a residual that any function of state can take, against residuals that are made of a known share of one."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from physident.diagnosis.remainder.predictable import predictable_share

RATE = 20.0  # Hz


def states(seed: int, count: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """A motion that visits its states often, and its clock."""
    time = np.arange(count) / RATE
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, 3)
    q = sum(np.sin((0.7 + 0.31 * k) * time + p) for k, p in enumerate(phase))
    v = np.gradient(q, 1 / RATE)
    return time, np.column_stack([q, v, np.gradient(v, 1 / RATE)])


def slow_noise(seed: int, count: int = 4000) -> np.ndarray:
    """Noise that remembers for a second and knows nothing of the state."""
    keep = np.exp(-1 / RATE)
    noise = np.asarray(lfilter([1.0], [1.0, -keep], np.random.default_rng(seed).standard_normal(count)))
    return noise / noise.std()


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7, 1.0])
def test_the_bound_lies_at_or_above_the_share_and_near_it(share: float) -> None:
    found = []
    for seed in range(6):
        time, x = states(seed)
        curve = np.sin(2 * x[:, 0]) + 0.5 * np.tanh(3 * x[:, 1])
        curve = (curve - curve.mean()) / curve.std()
        residual = np.sqrt(share) * curve + np.sqrt(1 - share) * slow_noise(seed + 50)
        bound = predictable_share(residual, x, time, np.zeros(len(time), dtype=np.intp), apart=10.0)
        assert bound is not None
        found.append(bound)
    actual = np.array(found)
    assert np.mean(actual >= share - 0.05) >= 0.8
    assert np.median(actual) < share + 0.4  # of a hundred independent samples


def test_states_that_were_visited_once_decide_nothing() -> None:
    time = np.arange(2000) / RATE
    ramp = np.column_stack([time, time**2])
    recording = np.zeros(2000, dtype=np.intp)
    assert predictable_share(slow_noise(1, 2000), ramp, time, recording, apart=10.0) is None


def test_recordings_are_independent_of_each_other() -> None:
    """Two recordings of one motion: what repeats is a function of state, what does not is none."""
    time, x = states(3, 2000)
    twice, clock = np.vstack([x, x]), np.concatenate([time, time])
    recording = np.repeat([0, 1], 2000)
    repeated = predictable_share(np.tile(slow_noise(1, 2000), 2), twice, clock, recording, apart=1e9)
    changed = predictable_share(slow_noise(2, 4000), twice, clock, recording, apart=1e9)
    assert repeated is not None
    assert repeated > 0.95
    assert changed is not None
    assert changed < 0.25
