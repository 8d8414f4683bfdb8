"""What an effect of several numbers is worth in a recording is told by the other recordings, not by itself."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from physident.diagnosis.grading import as_others_show as subject
from physident.diagnosis.grading.as_others_show import AsOthersShow, as_others_show

Array = NDArray[np.float64]
ROWS, KNOWN, SIZE = 150, 3, 8  # of a recording; numbers of the model and of the effect


def part(rng: np.random.Generator, recordings: int, torque: Array | None = None) -> Any:
    """Rows of one joint, with random columns of a model and of an effect."""
    columns = rng.standard_normal((ROWS * recordings, KNOWN + SIZE))
    given = rng.standard_normal(ROWS * recordings) if torque is None else torque
    return SimpleNamespace(
        time=np.arange(len(columns)),
        recording=np.repeat(np.arange(recordings), ROWS),
        columns=range(KNOWN + SIZE),
        joints=[SimpleNamespace(columns=np.arange(KNOWN + SIZE), values=columns)],
        torque=given[:, None],
    )


def hypothesis(values: Array) -> Any:
    return SimpleNamespace(
        extension=SimpleNamespace(
            places=[KNOWN + np.arange(SIZE)], model=SimpleNamespace(theta=np.zeros(KNOWN + SIZE))
        ),
        effect_values=[values],
        accepted=[SimpleNamespace(effect=None)],
        problem=SimpleNamespace(model=SimpleNamespace(robot=None, effects=None)),
        fit=SimpleNamespace(weights=np.ones(1)),
    )


@pytest.fixture(autouse=True)
def whole_model(monkeypatch: pytest.MonkeyPatch) -> None:
    known = SimpleNamespace(independent=np.arange(KNOWN))
    monkeypatch.setattr(subject, "find_base_parameters", lambda *_: known)


def fitted(before: Any, after: Any, left_out: int | None) -> Array:
    """The effect's values by least squares of all rows but those of one recording; the control has none of it."""
    kept = after.recording != left_out
    A = np.vstack([before.joints[0].values * (np.arange(KNOWN + SIZE) < KNOWN), after.joints[0].values[kept]])
    y = np.concatenate([before.torque[:, 0], after.torque[kept, 0]])
    return np.linalg.lstsq(A, y)[0][KNOWN:]


def shown(before: Any, after: Any) -> AsOthersShow:
    return as_others_show(hypothesis(fitted(before, after, None)), [0], before, after)


def test_the_values_of_a_recording_are_those_that_the_others_fit() -> None:
    rng = np.random.default_rng(0)
    before, after = part(rng, 3), part(rng, 3)
    one = shown(before, after)
    for recording in range(3):
        np.testing.assert_allclose(
            one.values_without[recording][KNOWN:, 0], fitted(before, after, recording), rtol=1e-6
        )
    columns = after.joints[0].values
    made = np.concatenate([columns[k * ROWS : (k + 1) * ROWS] @ one.values_without[k] for k in range(3)])
    np.testing.assert_allclose(one.torque(columns, after.recording), made)


def test_one_recording_and_one_number_are_left_as_they_are() -> None:
    rng = np.random.default_rng(1)
    assert not shown(part(rng, 3), part(rng, 1)).values_without
    single = hypothesis(np.ones(1))
    single.extension.places = [np.array([KNOWN])]
    assert not as_others_show(single, [0], part(rng, 3), part(rng, 2)).values_without


def test_chance_makes_no_size_of_an_effect_that_others_show_and_a_true_effect_has_its_own() -> None:
    """By the values of all new recordings noise would always have the size one."""
    rng, chance, by_own, true = np.random.default_rng(2), [], [], []
    for _ in range(60):
        before, after = part(rng, 3), part(rng, 2)
        columns = after.joints[0].values
        for found, real in ((chance, 0.0), (true, 1.0)):
            y = after.torque[:, 0] + real * columns[:, KNOWN:].sum(axis=1)
            seen = SimpleNamespace(**{**vars(after), "torque": y[:, None]})
            one = shown(before, seen)
            for values, into in (
                (one.torque(columns, after.recording)[:, 0], found),
                (columns @ one.values[:, 0], by_own),
            ):
                into.append(float(values @ y / (values @ values)))
    assert np.mean(by_own) == pytest.approx(1.0, abs=0.05)
    assert abs(np.mean(chance)) < 0.15
    assert np.mean(true) == pytest.approx(1.0, abs=0.05)


def test_what_one_recording_alone_shows_keeps_its_values() -> None:
    """A curve of a joint that the other recordings do not move is not nothing."""
    rng = np.random.default_rng(3)
    before, after = part(rng, 3), part(rng, 2)
    after.joints[0].values[after.recording == 1, KNOWN:] *= 0.01
    one = shown(before, after)
    np.testing.assert_allclose(one.values_without[0], one.values)
    assert not np.allclose(one.values_without[1], one.values)
