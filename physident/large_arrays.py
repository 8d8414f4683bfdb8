"""Arrays that may be larger than memory: above a size they lie in a temporary file, and are worked on in blocks of rows.

A recording of a day has as many numbers as a computer has bytes of memory. All that is computed from it is computed block by
block, by the same functions as for a short recording, which is one block. The files have no name and vanish with the arrays.
"""

from __future__ import annotations

import mmap
import os
import tempfile
import weakref
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextvars import ContextVar
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from physident.errors import InputError

Array = NDArray[np.float64]
LARGE = ContextVar("LARGE", default=16 << 20)  # bytes of an array, above which it lies in a file
BLOCK = 1 << 16  # rows worked on at once: a thousand filters long, and a few megabytes of each channel
STEP = 1 << 13  # rows of many columns worked on at once
_MAPPED: weakref.WeakSet[Any] = weakref.WeakSet()
_BITS = 16  # of a number that are counted in one pass


def empty(shape: int | tuple[int, ...], dtype: DTypeLike = float, shared: bool = False) -> NDArray[Any]:
    """An array to be filled, in memory or, above ``LARGE`` bytes or where processes must share it, in a temporary file.

    Raises InputError for a full disk.
    """
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    if not size or (size <= LARGE.get() and not shared):
        return np.empty(shape, dtype)
    folder = tempfile.gettempdir()
    try:
        with tempfile.TemporaryFile(prefix="physident-") as file:
            os.posix_fallocate(file.fileno(), 0, size) if hasattr(os, "posix_fallocate") else file.truncate(size)
            mapped = mmap.mmap(file.fileno(), size)
    except OSError as error:
        raise InputError(
            f"{size / 1e9:.1f} GB in {folder} are not to be had ({error.strerror}); expected room for twice the recording:"
            " set TMPDIR to a larger disk"
        ) from None
    _MAPPED.add(mapped)
    return np.frombuffer(mapped, dtype).reshape(shape)


def is_shared(values: NDArray[Any]) -> bool:
    """Whether several processes see the same array: it lies in a file."""
    while isinstance(values, np.ndarray) and values.base is not None:
        values = values.base
    return isinstance(values, mmap.mmap | memoryview)


def joined_rows(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Arrays (N_k, ...) one below the other; a single one as it is."""
    if len(parts) == 1:
        return parts[0]
    result = empty((sum(map(len, parts)), *parts[0].shape[1:]), parts[0].dtype)
    at = 0
    for part in parts:
        for rows in blocks(len(part)):
            result[at + rows.start : at + rows.stop] = part[rows]
        at += len(part)
    return result


def copied(values: NDArray[Any]) -> NDArray[Any]:
    """A copy of an array (N, ...) that can be written to."""
    result = empty(values.shape[::-1], values.dtype).T  # column by column, as a regressor is stored
    for rows in blocks(len(values)):
        result[rows] = values[rows]
    return result


def computed(shape: int | tuple[int, ...], rows_of: Callable[[slice], NDArray[Any]]) -> Array:
    """An array (N, ...) of which ``rows_of`` gives some rows, block by block."""
    result = empty(shape)
    for rows in blocks(len(result)):
        result[rows] = rows_of(rows)
    return result


def squares(values: Array) -> Array:
    """Sums (...) of the squares of values (N, ...)."""
    return np.sum([(values[rows] ** 2).sum(axis=0) for rows in blocks(len(values))], axis=0)


def picked(values: NDArray[Any], at: NDArray[np.intp]) -> NDArray[Any]:
    """The values (K, ...) at some rows (K,) of (N, ...), whose numbers do not fall: of an array in a file, only blocks are in memory."""
    result = np.empty((len(at), *values.shape[1:]), values.dtype)
    for rows in blocks(len(values)):
        some = slice(*np.searchsorted(at, (rows.start, rows.stop)))
        result[some] = values[at[some]]
    return result


def numbered(count: int, first: int = 1) -> NDArray[np.intp]:
    """The numbers (N,) of rows, from ``first`` on."""
    result = empty(count, np.intp)
    for rows in blocks(count):
        result[rows] = np.arange(first + rows.start, first + rows.stop)
    return result


def release() -> None:
    """Gives the memory of arrays in files back; their values stay, and are read again when they are needed."""
    for mapped in list(_MAPPED):
        if hasattr(mmap, "MADV_DONTNEED"):
            mapped.madvise(mmap.MADV_DONTNEED)


def blocks(count: int, size: int | None = None) -> Iterator[slice]:
    """Slices of at most ``size`` (``BLOCK``) of ``count`` rows, one after another; between them the memory of files is given
    back."""
    size = size or BLOCK
    for start in range(0, count, size):
        yield slice(start, min(start + size, count))
        if count > size:
            release()


def steps(count: int) -> Iterator[slice]:
    """Slices of ``STEP`` of ``count`` rows, for arrays of many columns; the memory of files is given back once in a block and at the end."""
    for start in range(0, count, STEP):
        stop = min(start + STEP, count)
        yield slice(start, stop)
        if count > STEP and (stop == count or stop % BLOCK == 0):
            release()


def is_finite(values: Array) -> bool:
    """Whether all values (N, ...) are finite."""
    return all(bool(np.isfinite(values[rows]).all()) for rows in blocks(len(values)))


def is_increasing(values: Array) -> bool:
    """Whether each value (N,) is larger than the one before."""
    return all(bool((np.diff(values[rows.start : rows.stop + 1]) > 0).all()) for rows in blocks(len(values)))


def scaled(values: Array, factors: Array) -> Array:
    """Values (N, n) times the factor of each column (n,)."""
    result = empty(values.shape)
    for rows in blocks(len(values)):
        result[rows] = values[rows] * factors
    return result


def limits(values: Array) -> Array:
    """The smallest and the largest (..., 2) of values (N, ...), N > 0."""
    ends = [(values[rows].min(axis=0), values[rows].max(axis=0)) for rows in blocks(len(values))]
    return np.stack([np.min([low for low, _ in ends], axis=0), np.max([high for _, high in ends], axis=0)], axis=-1)


def extent(values: Array) -> Array:
    """The difference (...) of the largest and the smallest of values (N, ...), N > 0."""
    ends = limits(values)
    return ends[..., 1] - ends[..., 0]


def magnitude(values: Array) -> Array:
    """The largest size (...) of values (N, ...), N > 0."""
    return np.max([np.abs(values[rows]).max(axis=0) for rows in blocks(len(values))], axis=0)


def triangle(pieces: Iterable[Array]) -> Array:
    """The R factor of the QR decomposition of pieces (N_k, p) one below the other."""
    R: Array | None = None
    for piece in pieces:
        R = np.asarray(np.linalg.qr(piece if R is None else np.concatenate([R, piece]), mode="r"))
    assert R is not None
    return R


def median(pieces: Callable[[], Iterator[Array]]) -> float:
    """The median of numbers that are not negative, which ``pieces`` yields anew on each call; NaN where there are none.

    One piece is sorted. Of several, the bits of the number in the middle are found one after another, by counting.
    """
    first = next(iter(pieces()), np.zeros(0))
    count = sum(piece.size for piece in pieces())
    if count == first.size:
        return float(np.median(first)) if count else float("nan")
    middle = [_ranked(pieces, rank) for rank in sorted({(count - 1) // 2, count // 2})]
    return float(np.mean(middle))


def _ranked(pieces: Callable[[], Iterator[Array]], rank: int) -> float:
    """The number with ``rank`` smaller ones: numbers that are not negative are ordered as their bits are."""
    known = 0
    for shift in range(64 - _BITS, -1, -_BITS):
        counts = np.zeros(1 << _BITS, dtype=np.int64)
        for piece in pieces():
            bits = np.abs(piece).ravel().view(np.uint64)
            if shift + _BITS < 64:
                bits = bits[bits >> np.uint64(shift + _BITS) == known]
            counts += np.bincount((bits >> np.uint64(shift)).astype(np.intp) & ((1 << _BITS) - 1), minlength=1 << _BITS)
        before = np.cumsum(counts)
        digit = int(np.searchsorted(before, rank, side="right"))
        rank -= int(before[digit - 1]) if digit else 0
        known = known << _BITS | digit
    return float(np.array([known], dtype=np.uint64).view(float)[0])


class Growing:
    """Rows (N, C) that arrive in blocks: the table of a file whose length is not known before it is read."""

    def __init__(self, width: int) -> None:
        self._width, self._blocks, self._file, self.rows = width, [], None, 0

    def add(self, block: Array) -> None:
        """Append rows (K, C)."""
        self._blocks.append(block)
        self.rows += len(block)
        if sum(one.nbytes for one in self._blocks) > LARGE.get():
            self._file = self._file or tempfile.TemporaryFile(prefix="physident-")  # noqa: SIM115  (closed by table)
            self._spill()

    def table(self) -> Array:
        """All rows (N, C)."""
        if self._file is None:
            values = np.empty((self.rows, self._width))
            at = self.rows
            while self._blocks:  # each is freed as soon as it is copied
                block = self._blocks.pop()
                values[at - len(block) : at] = block
                at -= len(block)
            return values
        with self._file as file:
            self._spill()
            file.flush()
            mapped = mmap.mmap(file.fileno(), self.rows * self._width * 8)
        _MAPPED.add(mapped)
        return np.frombuffer(mapped, float).reshape(self.rows, self._width)

    def _spill(self) -> None:
        assert self._file is not None
        try:
            for block in self._blocks:
                self._file.write(np.ascontiguousarray(block, dtype=float).data)
        except OSError as error:
            raise InputError(
                f"{tempfile.gettempdir()} has no room for the recording ({error.strerror}); set TMPDIR to a larger disk"
            ) from None
        self._blocks = []


def row_slices(parts: Sequence[slice]) -> Iterator[slice]:
    """Blocks of at most ``BLOCK`` samples, none of which crosses from one of the parts into another."""
    for part in parts:
        for rows in blocks(part.stop - part.start):
            yield slice(part.start + rows.start, part.start + rows.stop)
