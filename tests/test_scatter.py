"""How much an effect's size differs between recordings: found where it is, against a truth that was drawn."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from physident.diagnosis.grading import control
from physident.diagnosis.grading.scatter import Scatter, block_variances, scatter_between

ROWS = 120  # of a recording


@pytest.mark.parametrize(("between", "low", "high"), [(0.0, 0.0, 0.003), (0.5, 0.17, 0.33)])
def test_what_recordings_differ_by_is_found_beyond_the_noise(between: float, low: float, high: float) -> None:
    rng = np.random.default_rng(1)
    found = []
    for _ in range(200):
        recordings = 4
        which = np.repeat(np.arange(recordings), ROWS)
        columns = [rng.standard_normal((recordings * ROWS, 3)) for _ in range(2)]
        effect = [rng.standard_normal(recordings * ROWS), np.zeros(recordings * ROWS)]
        size = rng.normal(1.0, between, recordings)[which] if between else np.ones(len(which))
        torque = [
            A @ [1.0, -2.0, 0.5] + c * size + rng.standard_normal(len(which))
            for A, c in zip(columns, effect, strict=True)
        ]
        columns = [np.column_stack([A, c]) for A, c in zip(columns, effect, strict=True)]
        rows = SimpleNamespace(recording=which, segment=which, kept_rate=10.0)
        one = scatter_between([rows], which, columns, torque, effect)  # pyright: ignore[reportArgumentType]
        assert one.count == recordings
        found.append(one.variance)
    assert low <= np.mean(found) <= high


def test_a_recording_that_does_not_show_an_effect_does_not_count() -> None:
    rng = np.random.default_rng(2)
    which = np.repeat(np.arange(3), ROWS)
    effect = rng.standard_normal(len(which)) * (which > 0)
    columns = np.column_stack([rng.standard_normal(len(which)), effect])
    torque = columns @ [1.0, 1.0] + 0.1 * rng.standard_normal(len(which))
    rows = SimpleNamespace(recording=which, segment=which, kept_rate=10.0)
    one = scatter_between([rows], which, [columns], [torque], [effect])  # pyright: ignore[reportArgumentType]
    assert one.count == 2


def test_what_changed_between_two_times_is_no_scatter_and_both_times_tell_of_it() -> None:
    """Three recordings before and two after, whose mean size is 5 more: only what those of one time differ by counts."""
    rng, found = np.random.default_rng(4), []
    before, after = (SimpleNamespace(recording=np.repeat(np.arange(k), ROWS), kept_rate=10.0) for k in (3, 2))
    for part in (before, after):
        part.segment = part.recording
    each = np.concatenate([before.recording, after.recording + 3])
    for _ in range(300):
        columns, effect = rng.standard_normal((len(each), 3)), rng.standard_normal(len(each))
        size = rng.normal(np.array([1.0, 1.0, 1.0, 6.0, 6.0]), 0.5)[each]
        torque = columns @ [1.0, -2.0, 0.5] + effect * size + 0.5 * rng.standard_normal(len(each))
        one = scatter_between([before, after], each, [np.column_stack([columns, effect])], [torque], [effect])  # pyright: ignore[reportArgumentType]
        assert one.count == 4  # as three differences are known
        found.append(one.variance)
    assert 0.2 < np.mean(found) < 0.3


def test_long_waves_are_seen_in_long_blocks() -> None:
    """Of a wave that lasts a tenth of the rows, short blocks know too little."""
    rng = np.random.default_rng(3)
    segment = np.zeros(4000, dtype=np.intp)
    true, short, longest = [], [], []
    for _ in range(100):
        push = np.repeat(rng.standard_normal(10), 400) + rng.standard_normal(4000)
        true.append(push.sum() ** 2)
        own = SimpleNamespace(segment=segment, kept_rate=10.0)
        of_lengths = list(block_variances(push - push.mean(), segment, [own]))  # pyright: ignore[reportArgumentType]
        short.append(np.sum((push - push.mean()) ** 2))
        longest.append(max(variance for variance, _ in of_lengths))
    assert np.mean(short) < 0.05 * np.mean(true)
    assert 0.5 * np.mean(true) < np.mean(longest) < 2 * np.mean(true)


@pytest.mark.parametrize(
    ("noise", "usual", "changed"),
    [
        ((0.02,), (0.0,), (False,)),  # noise does it once in fifty times
        ((0.002,), (0.0,), (True,)),
        ((0.002,), (0.1,), (False,)),  # healthy recordings differ so once in ten times
        (
            (0.006, 0.004),
            (0.0, 0.0),
            (False, True),
        ),  # of two, each must be twice as certain; the less certain one is dropped
        ((0.004, 0.003), (0.0, 0.0), (True, True)),
    ],
)
def test_a_change_is_what_neither_noise_nor_a_healthy_arm_makes(
    monkeypatch: pytest.MonkeyPatch, noise: tuple[float, ...], usual: tuple[float, ...], changed: tuple[bool, ...]
) -> None:
    found = [control.Difference(size=1.0, noise=a, usual=b) for a, b in zip(noise, usual, strict=True)]
    few = Scatter(variance=1.0, count=2)
    fit = SimpleNamespace(differences=lambda left: [found[k] for k in left], scatter=lambda _: few)
    monkeypatch.setattr(control, "_joint_fit", lambda *_: fit)
    places = [np.array([k]) for k in range(len(noise))]
    state: Any = SimpleNamespace(
        problem=SimpleNamespace(model=SimpleNamespace(theta=np.zeros(len(noise)))),
        extension=SimpleNamespace(places=places),
    )
    assert tuple(one.size != 0 for one in control.changes_of(state, (), range(len(noise)))) == changed
