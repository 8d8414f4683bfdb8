"""The filter against scipy, derivatives against known motions, and gaps that must not leak."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

import physident as pid
from physident.recordings.channels import Channels
from physident.recordings.recording import recording_from_rows


def _recording(time: np.ndarray, with_dq: bool) -> pid.Recording:
    phase = np.array([0.0, 1.0])
    q = np.sin(2 * np.pi * 0.5 * time[:, None] + phase)
    dq = np.pi * np.cos(2 * np.pi * 0.5 * time[:, None] + phase)
    return recording_from_rows(
        Channels(time=time, q=q, effort=q + 1, effort_kind="torque", dq=dq if with_dq else None), "made"
    )


@pytest.mark.parametrize("rate", [93.7, 125.0, 500.0, 1000.0])
@pytest.mark.parametrize("cutoff", [2.0, 5.0, 8.0])
def test_filter_equals_scipy_with_the_same_taps(rate: float, cutoff: float) -> None:
    filter = pid.Filter(cutoff)
    x = np.random.default_rng(0).normal(size=(3, int(6 * rate)))
    ours = filter.apply(x, rate)
    taps, D, half = filter.taps(rate), filter.decimation(rate), filter.delay(rate) * filter.decimation(rate)
    full = np.asarray(lfilter(taps, 1.0, x, axis=-1))[:, 2 * half :]
    assert ours.shape[1] == filter.kept(x.shape[1], rate)
    np.testing.assert_allclose(ours, full[:, ::D][:, : ours.shape[1]], atol=1e-12)
    assert ours.shape[1] == full[:, ::D].shape[1]


def test_filter_has_unit_gain_at_rest_half_gain_at_cutoff_and_no_phase() -> None:
    filter, rate = pid.Filter(5.0), 125.0
    time = np.arange(2000) / rate
    half = filter.delay(rate) * filter.decimation(rate)
    for frequency, gain in ((0.0, 1.0), (1.0, 1.0), (5.0, 0.5), (9.0, 0.0)):
        wave = np.cos(2 * np.pi * frequency * time)[None]
        kept = filter.apply(wave, rate)[0]
        centres = time[half + np.arange(len(kept)) * filter.decimation(rate)]
        np.testing.assert_allclose(kept, gain * np.cos(2 * np.pi * frequency * centres), atol=6e-3)


@pytest.mark.parametrize("with_dq", [True, False])
def test_derivatives_of_a_known_motion(with_dq: bool) -> None:
    rng = np.random.default_rng(1)
    time = np.cumsum(np.concatenate([[0.0], rng.uniform(0.007, 0.009, size=2500)]))  # jitter
    signals = pid.prepare(_recording(time, with_dq), pid.Filter(5.0))
    w, phase = 2 * np.pi * 0.5, np.array([0.0, 1.0])
    inner = slice(50, -50)
    angle = w * signals.time[inner, None] + phase
    assert np.abs(signals.q[inner] - np.sin(angle)).max() < 2e-4
    assert np.abs(signals.v[inner] - w * np.cos(angle)).max() < 2e-2
    filtered = pid.Filter(5.0).apply((signals.a[inner] + w**2 * np.sin(angle)).T, signals.rate)
    assert np.abs(filtered).max() < 0.01 * w**2


def test_gap_splits_and_nothing_crosses_it() -> None:
    time = np.concatenate([np.arange(0, 5, 0.008), np.arange(9, 14, 0.008)])
    signals = pid.prepare(_recording(time, with_dq=True), pid.Filter(5.0))
    assert len(signals.segments) == 2
    first, second = signals.segments
    assert signals.time[first][-1] < 5.0
    assert signals.time[second][0] >= 9.0
    assert np.abs(signals.v[:, 0]).max() < np.pi * 1.01  # interpolating over the gap would differ


def test_moving_part_is_found() -> None:
    time = np.arange(0, 10, 0.008)
    moving = (time > 3) & (time < 7)
    v = np.where(moving[:, None], 0.5, 0.0) * np.ones((1, 2))
    signals = pid.Signals(time, np.cumsum(v, axis=0) * 0.008, v, np.zeros_like(v), v, rate=125.0)
    start, stop = signals.moving or (np.nan, np.nan)
    assert start == pytest.approx(3.008 - 0.2, abs=0.01)
    assert stop == pytest.approx(6.992 + 0.2, abs=0.01)


@pytest.mark.parametrize("cutoff", [0.0, -1.0, float("nan"), float("inf")])
def test_impossible_cutoffs_are_refused(cutoff: float) -> None:
    with pytest.raises(pid.InputError, match="cutoff"):
        pid.Filter(cutoff)


def test_cutoff_above_the_clock_is_refused() -> None:
    with pytest.raises(pid.InputError, match="too high"):
        pid.prepare(_recording(np.arange(0, 5, 0.01), True), pid.Filter(60.0))
