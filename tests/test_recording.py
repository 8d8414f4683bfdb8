"""Recordings: good rows stay, bad rows are named, the clock is mended by taking out the fewest rows."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import physident as pid
from physident.recordings.channels import Channels
from physident.recordings.recording import recording_from_rows
from physident.recordings.rows import MAX_SPEED
from tests.conftest import UR10E_COLUMNS, UR10E_GAINS

seeds = st.integers(0, 10_000)


def motion(rng: np.random.Generator, n: int, count: int = 300) -> tuple[np.ndarray, ...]:
    """Time with jitter, position, velocity and torque of an arm of n joints that moves smoothly."""
    time = np.cumsum(rng.uniform(0.008, 0.02, count)) + rng.uniform(0, 2e9)
    w, phase = rng.uniform(0.5, 6, n), rng.uniform(0, 6, n)
    angle = np.outer(time - time[0], w) + phase
    return time, 0.8 * np.sin(angle), 0.8 * w * np.cos(angle), rng.normal(scale=50, size=(count, n))


def record(time: np.ndarray, q: np.ndarray, dq: np.ndarray, tau: np.ndarray) -> pid.Recording:
    return recording_from_rows(Channels(time=time, q=q, effort=tau, effort_kind="torque", dq=dq), "test")


@given(seeds, st.integers(1, 9))
@settings(max_examples=50, deadline=None)
def test_a_clean_recording_loses_no_row(seed: int, n: int) -> None:
    channels = motion(np.random.default_rng(seed), n)
    recording = record(*channels)
    assert recording.rejected == ()
    for kept, given_ in zip((recording.time, recording.q, recording.dq, recording.effort), channels, strict=True):
        np.testing.assert_array_equal(kept, given_)


@given(seeds)
@settings(max_examples=60, deadline=None)
def test_corrupt_rows_are_named_exactly(seed: int) -> None:
    rng = np.random.default_rng(seed)
    channels = motion(rng, 6)
    bad = np.sort(rng.choice(np.arange(300), rng.integers(1, 40), replace=False))
    for row in bad:
        channel = channels[rng.integers(1, 4)]
        channel[row, rng.integers(6)] = rng.choice([np.nan, np.inf, -np.inf, 1e290, -1e17])
    recording = record(*channels)
    assert [b.row for b in recording.rejected] == (bad + 1).tolist()
    np.testing.assert_array_equal(recording.time, np.delete(channels[0], bad))


@given(seeds)
@settings(max_examples=40, deadline=None)
def test_bursts_between_impossible_steps_are_named(seed: int) -> None:
    rng = np.random.default_rng(seed)
    time, q, dq, tau = motion(rng, 3)
    start, length = rng.integers(20, 270), rng.integers(1, 9)
    q[start : start + length] += 2 * MAX_SPEED * 0.02 * rng.choice([-1, 1])
    assert [b.row for b in record(time, q, dq, tau).rejected] == list(range(start + 1, start + length + 1))


@given(st.lists(st.integers(0, 6), min_size=4, max_size=9))
@settings(max_examples=60, deadline=None)
def test_the_clock_is_mended_by_taking_out_the_fewest_rows(steps: list[int]) -> None:
    """Against all subsets: no larger set of rows has an increasing clock."""
    from physident.recordings.rows import _not_increasing

    time = np.array(steps, dtype=float)
    out = _not_increasing(time)
    kept = np.delete(time, out)
    assert (np.diff(kept) > 0).all()
    larger = combinations(time, len(kept) + 1)
    assert not any((np.diff(some) > 0).all() for some in larger)


def test_a_clock_that_jumps_back_once_loses_the_rows_that_repeat() -> None:
    time, q, dq, tau = motion(np.random.default_rng(0), 2)
    order = np.r_[0:200, 150:300]  # fifty rows are sent twice
    recording = record(*(x[order] for x in (time, q, dq, tau)))
    assert len(recording.rejected) == 50
    np.testing.assert_array_equal(recording.time, time)


def test_arrays_are_read_only_and_the_given_ones_untouched() -> None:
    channels = motion(np.random.default_rng(1), 2)
    before = [x.copy() for x in channels]
    recording = record(*channels)
    with pytest.raises(ValueError, match="read-only"):
        recording.q[0, 0] = 1.0
    for x, copy in zip(channels, before, strict=True):
        np.testing.assert_array_equal(x, copy)
        assert x.flags.writeable


def test_torque_is_current_times_gain_and_asked_for_only_where_known() -> None:
    time, q, dq, amps = motion(np.random.default_rng(2), 2)
    recording = recording_from_rows(Channels(time=time, q=q, effort=amps, effort_kind="current", dq=dq), "test")
    with pytest.raises(pid.InputError, match="no drive gains"):
        _ = recording.torque
    gained = recording.with_drive_gains([10.0, -3.0])
    np.testing.assert_array_equal(gained.torque, amps * [10.0, -3.0])
    assert gained.sha256 == recording.sha256  # the same measurement
    for wrong in ([1.0], [1.0, 0.0], [1.0, np.nan]):
        with pytest.raises(pid.InputError, match="drive gains"):
            recording.with_drive_gains(wrong)


def test_degrees_and_milliseconds_are_called_by_name() -> None:
    time, q, dq, tau = motion(np.random.default_rng(3), 2)
    with pytest.raises(pid.InputError, match="convert degrees"):
        record(time, np.degrees(q), dq, tau)
    with pytest.raises(pid.InputError, match="milliseconds"):
        record(1000 * (time - time[0]), q, dq, tau)
    with pytest.raises(pid.InputError, match=r"\(4 Hz\).*record faster"):
        record(0.25 * np.arange(len(time)), q, dq, tau)
    with pytest.raises(pid.InputError, match="at least 2 s"):
        record(*(x[:100] for x in (time - time[0], q, dq, tau)))


def test_every_real_recording_loads(data: Path) -> None:
    files = sorted(data.glob("ur10e/*.csv"))
    assert len(files) == 15
    for recording in pid.load_recordings(files, UR10E_COLUMNS, UR10E_GAINS):
        assert not recording.rejected or recording.source.endswith("ur-19_09_27-11_32_02.csv")
        assert recording.n == 6
        assert recording.duration > 2
    five = pid.load_recordings(str(data / "ur5" / "*.csv.gz"))
    assert len(five) == 7
    assert all(r.n == 6 and r.effort_kind == "current" and not r.rejected for r in five)


def test_the_corrupt_rows_of_a_real_recording_are_named(data: Path) -> None:
    """Ten rows hold numbers beyond any arm's; the rows between them are shifted by bytes, and go with the burst."""
    path = data / "ur10e" / "ur-19_09_27-11_32_02.csv"
    numbers = np.loadtxt(path, delimiter=",")
    impossible = np.flatnonzero((np.abs(numbers) > 1e10).any(axis=1)) + 1
    assert impossible.tolist() == [3, 4, 7, 8, 11, 12, 16, 17, 19, 20]
    recording = pid.load_recording(path, UR10E_COLUMNS)
    named = {b.row: b.reason for b in recording.rejected}
    assert all("absurd" in named[row] for row in impossible.tolist())
    assert sorted(named) == list(range(1, 21))
    np.testing.assert_array_equal(recording.q, numbers[20:, 1:7])
