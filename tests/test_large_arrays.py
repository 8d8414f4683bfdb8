"""Arrays in files and in blocks hold the same numbers as arrays in memory."""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from physident import large_arrays
from physident.errors import InputError
from physident.large_arrays import LARGE, Growing, blocks, empty, is_shared, median, triangle
from physident.processes import VARIABLE, each, mapped, processors
from physident.recordings.motion_smoothing import MotionNoise, _liveliest, encoder_step, smooth_motion
from physident.recordings.rests import find_rests
from physident.recordings.white_noise import white_noise

Array = np.ndarray


def walk(seed: int, count: int = 3000) -> Array:
    """Positions of a joint that moves and rests, rounded to a step."""
    rng = np.random.default_rng(seed)
    speed = np.repeat(rng.normal(0, 1, count // 50) * (rng.random(count // 50) > 0.3), 50)
    return np.round(np.cumsum(speed) * 2e-3, 4)


@given(st.integers(1, 400), st.integers(0, 400))
def test_blocks_cover_every_row_once(size: int, count: int) -> None:
    rows = [i for block in blocks(count, size) for i in range(block.start, block.stop)]
    assert rows == list(range(count))


@given(hnp.arrays(float, st.integers(1, 60), elements=st.floats(0, 1e6) | st.just(0.5)), st.integers(1, 70))
def test_median_of_pieces(values: Array, size: int) -> None:
    assert median(lambda: (values[b] for b in blocks(len(values), size))) == np.median(values)


@given(st.integers(3, 40), st.integers(0, 5))
def test_triangle_of_pieces_has_the_same_products(size: int, seed: int) -> None:
    A = np.random.default_rng(seed).normal(size=(100, 4))
    R = triangle(A[b] for b in blocks(100, size))
    np.testing.assert_allclose(R.T @ R, A.T @ A, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("block", [7, 100, 1000, 2999])
def test_what_is_of_the_whole_motion_does_not_depend_on_blocks(monkeypatch: pytest.MonkeyPatch, block: int) -> None:
    q = walk(1)
    v = np.gradient(q)
    torque = np.random.default_rng(2).normal(size=(3000, 2))
    whole = _liveliest(q, 600), encoder_step(q), find_rests(q, v, 1e-4, 1e-2), white_noise(torque)
    assert len(whole[2].start) > 5
    monkeypatch.setattr(large_arrays, "BLOCK", block)
    rests = find_rests(q, v, 1e-4, 1e-2)
    assert _liveliest(q, 600) == whole[0]
    assert encoder_step(q) == whole[1]
    for name in ("start", "stop", "before", "after"):
        np.testing.assert_array_equal(getattr(rests, name), getattr(whole[2], name))
    np.testing.assert_allclose(white_noise(torque), whole[3], rtol=1e-12)


@pytest.mark.parametrize("measured", [True, False])
@pytest.mark.parametrize("position", [1e-5, 1e-3])
@pytest.mark.parametrize("piece", [3000, 10_001, 39_999])
def test_a_motion_solved_for_in_pieces_is_that_of_the_whole(
    monkeypatch: pytest.MonkeyPatch, piece: int, position: float, measured: bool
) -> None:
    rng, time = np.random.default_rng(3), np.arange(40_000) / 500
    q = np.sin(time) + position * rng.normal(size=time.shape)
    dq = np.cos(time) + 1e-2 * rng.normal(size=time.shape) if measured else None
    # the smoother with the longest memory that the search for the noise allows
    noise = MotionNoise(position=position, velocity=1e-2, clock=1e-7, jerk=position**2 * 500.0**5 / 100**6)
    whole = smooth_motion(q, dq, 500.0, noise)
    monkeypatch.setattr("physident.recordings.motion_smoothing.PIECE", piece)
    parts = smooth_motion(q, dq, 500.0, noise)
    for name in ("q", "v", "a"):
        size = np.abs(getattr(whole, name)).max()
        np.testing.assert_allclose(getattr(parts, name), getattr(whole, name), atol=1e-9 * size)


def test_arrays_in_files_can_be_filled_by_several_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "2")
    values = empty((1000, 3), shared=True)
    assert is_shared(values)
    assert is_shared(values[3:].T)
    assert not is_shared(np.zeros(3))

    def fill(k: int) -> None:
        values[k] = k

    each(fill, range(1000), shared=True)
    np.testing.assert_array_equal(values[:, 1], np.arange(1000))

    def fail(k: int) -> None:
        if k == 1:
            raise InputError("of the second process")

    with pytest.raises(InputError, match="of the second process"):
        each(fail, range(4), shared=True)


@pytest.mark.parametrize("processes", ["1", "2", "3"])
def test_what_several_processes_return_comes_in_order(monkeypatch: pytest.MonkeyPatch, processes: str) -> None:
    monkeypatch.setenv(VARIABLE, processes)
    assert mapped(lambda k: {k, k**2}, range(8)) == [{k, k**2} for k in range(8)]
    assert mapped(lambda k: k, []) == []

    def fail(k: int) -> int:
        if k == 1:
            raise InputError("of the second item")
        return k

    with pytest.raises(InputError, match="of the second item"):
        mapped(fail, range(4))


def test_a_process_that_is_ended_from_outside_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "2")
    with pytest.raises(RuntimeError, match="ended from outside"):
        mapped(lambda k: os._exit(3) if k == 1 else k, range(2))


def test_rows_that_arrive_in_blocks_may_outgrow_memory() -> None:
    token = LARGE.set(1000)
    try:
        rows, given = Growing(3), np.random.default_rng(0).normal(size=(500, 3))
        for block in blocks(500, 60):
            rows.add(given[block])
        table = rows.table()
    finally:
        LARGE.reset(token)
    assert is_shared(table)
    np.testing.assert_array_equal(table, given)


@pytest.mark.parametrize("given", ["0", "two", "-1", ""])
def test_a_wrong_number_of_processes_is_refused(monkeypatch: pytest.MonkeyPatch, given: str) -> None:
    monkeypatch.setenv(VARIABLE, given)
    with pytest.raises(InputError, match=VARIABLE):
        processors()
