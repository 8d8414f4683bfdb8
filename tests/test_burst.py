"""When a residual is larger than ever else is found, and noise has no such time."""

from __future__ import annotations

import json
from dataclasses import fields

import numpy as np
import pytest

from physident.diagnosis.remainder.burst import Burst, bursts_in_words, bursts_of
from physident.diagnosis.remainder.friction_between import FrictionBetween
from physident.diagnosis.remainder.unexplained import Unexplained
from physident.json_records import RecordReader

RATE, DURATION = 20.0, 30.0  # Hz, s of each of two recordings
NAMES = ("first.csv", "second.csv")
REMEMBERED = 4  # rows


def rows() -> tuple[np.ndarray, np.ndarray]:
    """Times since each recording began, and the place of each row's recording."""
    time = np.arange(0.0, DURATION, 1 / RATE)
    return np.tile(time, 2), np.repeat([0, 1], len(time))


def noise(seed: int) -> np.ndarray:
    """A moving mean of white noise: a residual that remembers, of variance one."""
    time, _ = rows()
    white = np.random.default_rng(seed).standard_normal(len(time) + REMEMBERED - 1)
    return np.convolve(white, np.full(REMEMBERED, REMEMBERED**-0.5), "valid")


def test_a_time_that_differs_is_found_and_measured() -> None:
    time, recording = rows()
    pushed = (recording == 1) & (time >= 9.0) & (time < 12.0)
    residual = np.where(pushed, 5.0, 1.0) * noise(0)
    (found,) = bursts_of(residual, time, recording, NAMES, len(time) / REMEMBERED)
    assert found.recording == "second.csv"
    assert found.start == pytest.approx(9.0, abs=0.5)
    assert found.end == pytest.approx(12.0, abs=0.5)
    inside = (recording == 1) & (time >= found.start) & (time < found.end)
    assert found.share == pytest.approx(np.sum(residual[inside] ** 2) / np.sum(residual**2))
    assert found.of_time == pytest.approx(inside.mean())


def test_noise_of_one_size_has_no_burst_and_what_is_large_all_along_is_none() -> None:
    time, recording = rows()
    worth = len(time) / REMEMBERED
    found = [bursts_of(noise(seed), time, recording, NAMES, worth) for seed in range(200)]
    assert sum(map(bool, found)) <= 6  # of 200 at a hundredth each
    few = [bursts_of(noise(seed)[::60], time[::60], recording[::60], NAMES, 20.0) for seed in range(200)]
    assert sum(map(bool, few)) <= 6  # twenty samples: a third of the power is soon in one of them
    half = np.where(recording == 1, 4.0, 1.0) * noise(0)
    assert bursts_of(half, time, recording, NAMES, worth) == ()


def test_what_is_more_than_friction_holds_is_no_joint_that_stands() -> None:
    """Most rows of the time are calm, and most of its power is not."""
    time, recording = rows()
    standing = (recording == 1) & (time >= 9.0) & (time < 12.0)
    residual = np.where(standing, 5.0, 1.0) * noise(0)
    worth = len(time) / REMEMBERED
    for level, rests in ((50.0, True), (4.0, False)):
        held = standing & (np.abs(residual) <= level)
        assert held[standing].mean() > 0.5
        (found,) = bursts_of(residual, time, recording, NAMES, worth, held)
        assert found.at_rest is rests
        assert ("friction of any size" in bursts_in_words((found,))) is rests


@pytest.mark.parametrize("second", [20.0, 8.0])
def test_every_time_that_differs_is_told_and_a_lesser_share_is_not(second: float) -> None:
    """Two pushes in one recording, and a brake that drags for a third of the other."""
    time, recording = rows()
    large, small = ((time >= start) & (time < start + 2.0) & (recording == 0) for start in (3.0, second))
    drags = (time >= 12.0) & (time < 22.0) & (recording == 1)
    residual = noise(3) * np.where(large | small, 6.0, np.where(drags, 4.0, 1.0))
    found = bursts_of(residual, time, recording, NAMES, len(time) / REMEMBERED)
    told = {(one.recording, round(one.start), round(one.end)) for one in found}
    assert told == {("first.csv", 3, 5), ("first.csv", second, second + 2), ("second.csv", 12, 22)}
    assert [one.share for one in found] == sorted((one.share for one in found), reverse=True)
    words = bursts_in_words(found)
    two = f"between 3.0 and 5.0 s and between {second:.1f} and {second + 2:.1f} s of first.csv"
    assert f"{two}, and between 12.0 and 22.0 s of second.csv" in words
    assert words.startswith(f"{100 * sum(one.share for one in found):.0f} % of it lies between")
    faint = noise(3) * np.where(large, 2.0, 1.0)  # a tenth of the power
    assert bursts_of(faint, time, recording, NAMES, len(time) / REMEMBERED) == ()


def test_a_joint_that_stood_then_is_no_event() -> None:
    time, recording = rows()
    stuck = (time >= 3.0) & (time < 5.0) & (recording == 0)
    residual = noise(3) * np.where(stuck, 6.0, 1.0)
    for resting, words in ((stuck, "the joint stood or crept then"), (~stuck, "see what happened then")):
        (found,) = bursts_of(residual, time, recording, NAMES, len(time) / REMEMBERED, resting)
        assert found.at_rest == (resting is stuck)
        assert words in bursts_in_words([found])


def test_a_burst_is_written_and_read_back() -> None:
    burst = Burst(recording="now.csv", start=9.5, end=12.0, share=0.49, of_time=0.07)
    numbers = dict.fromkeys(
        [f.name for f in fields(Unexplained) if f.name not in ("joint", "predictable", "bursts", "friction_between")],
        0.5,
    )
    between = FrictionBetween(share=0.35, percent=4.4)
    one = Unexplained(joint=2, **numbers, bursts=(burst,), friction_between=between)
    assert RecordReader("again").read(Unexplained, json.loads(json.dumps(one.as_dict())), "unexplained") == one
    assert "49 % of it lies between 9.5 and 12.0 s of now.csv" in one.description
    assert between.in_words in one.description


def test_what_happens_at_the_same_time_in_every_recording_is_told() -> None:
    """A program that starts a brake, or a pump, at its eighth second: no recording shows what the others are without it."""
    time, recording = rows()
    drags = (time >= 8.0) & (time < 16.0)
    found = bursts_of(np.where(drags, 5.0, 1.0) * noise(0), time, recording, NAMES, 40.0)  # it remembers
    assert sorted((one.recording, round(one.start), round(one.end)) for one in found) == [
        ("first.csv", 8, 16),
        ("second.csv", 8, 16),
    ]
