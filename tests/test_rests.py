"""A rest is a stretch of a recording without displacement; a crossing of zero speed is none."""

from __future__ import annotations

import numpy as np
import pytest

from physident.recordings.rests import Rests, fewest_samples, find_rests

RATE = 125.0


def test_a_crossing_is_not_a_rest() -> None:
    time = np.arange(500) / RATE
    q, v = np.cos(2 * np.pi * 0.5 * time), -np.pi * np.sin(2 * np.pi * 0.5 * time)
    assert len(find_rests(q, v, 5e-5, 1e-3).start) == 0  # it turns back at 10 rad/s^2: 6e-4 rad within three samples


@pytest.mark.parametrize("rate", [125.0, 500.0, 1000.0, 4000.0])
def test_a_joint_that_creeps_towards_its_reversal_moves(rate: float) -> None:
    """It turns back at 0.3 rad/s^2 under an encoder of 1e-4 rad, which sees nothing for 50 ms; its velocity is known to 1e-3 rad/s."""
    time = np.arange(-1.0, 1.0, 1 / rate)
    rests = find_rests(-0.15 * time**2, -0.3 * time, 1e-4, 1e-3, fewest_samples(rate, cutoff=5.0))
    assert float((rests.stop - rests.start).sum()) / rate < 0.03


def test_a_rest_goes_on_though_a_velocity_errs_now_and_then() -> None:
    rng = np.random.default_rng(0)
    v = np.concatenate([np.full(100, 0.5), 1e-3 * rng.standard_normal(2000), np.full(100, 0.5)])
    q = np.concatenate([np.linspace(-0.4, 0, 100), np.zeros(2000), np.linspace(0, 0.4, 100)])
    assert np.abs(v[100:2100]).max() > 3e-3
    rests = find_rests(q, v, 1e-4, 1e-3)
    assert len(rests.start) == 1
    assert float((rests.stop - rests.start)[0]) == pytest.approx(2000, abs=4)


@pytest.mark.parametrize("step", [0.0, 5e-5, 1e-3])
def test_a_rest_is_found_with_the_velocities_around_it(step: float) -> None:
    time = np.arange(600) / RATE
    v = np.where(time < 1.6, 0.5, np.where(time < 3.2, 0.0, -0.3))
    q = np.concatenate([[0.0], np.cumsum(v[:-1])]) / RATE
    q = step * np.round(q / step) if step else q
    rests = find_rests(q, v, max(step, 1e-9), 1e-3)
    assert len(rests.start) == 1
    # the first sample at rest and the first of the new motion are at the same position
    assert abs(int(rests.start[0]) - 200) <= 1
    assert abs(int(rests.stop[0]) - 401) <= 1
    assert rests.before[0] == 0.5
    assert rests.after[0] == -0.3


def test_a_recording_that_begins_and_ends_at_rest() -> None:
    q = np.concatenate([np.zeros(50), np.linspace(0, 1, 100), np.ones(50)])
    rests = find_rests(q, np.gradient(q), 1e-6, 1e-3)
    assert len(rests.start) == 2
    assert np.isnan(rests.before[0])
    assert np.isnan(rests.after[1])
    assert not np.isnan([rests.after[0], rests.before[1]]).any()


def test_parts_and_joins_keep_the_samples() -> None:
    rests = find_rests(
        np.concatenate([np.arange(10.0), np.full(20, 9.0), np.arange(9.0, 20.0)]), np.zeros(41), 1e-6, 1e-3
    )
    mask = rests.mask(41)
    cuts = [(0, 15), (15, 25), (25, 41)]
    parts = [rests.part(*cut) for cut in cuts]
    for part, (first, last) in zip(parts, cuts, strict=True):
        np.testing.assert_array_equal(part.mask(last - first), mask[first:last])
    # how far into the rest each sample is does not depend on the cut
    index, _, u = rests.samples(41)
    _, _, inside = parts[1].samples(10)
    np.testing.assert_allclose(inside, u[(index >= 15) & (index < 25)])
    whole = [find_rests(np.zeros(5), np.zeros(5), 1e-6, 1e-3)] * 2
    np.testing.assert_array_equal(Rests.joined(whole, [5, 5]).start, [0, 5])
