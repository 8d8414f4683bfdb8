"""MATLAB files: variables ``time`` (N,), ``q``, ``dq``, ``tau`` or ``current``, ``temperature`` (N, n), or a struct of them.

One variable is in memory at a time. Its numbers are stored column by column, so that none of its rows is complete before its end.
"""

from __future__ import annotations

import os
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.large_arrays import blocks, empty
from physident.recordings.columns.header import CHANNELS
from physident.recordings.formats.table import MOST_CELLS, Table, check_size, table_of_arrays

Array = NDArray[np.float64]

TEXT = 128  # bytes of the header
COMPRESSED = 15  # kind of a variable
BLOCK = 1 << 20  # bytes
HDF5 = b"\x89HDF\r\n\x1a\n"
EXPECTED = "expected arrays time (N,), q (N, n), tau (N, n), saved by save('file.mat', '-v7')"


def read_mat(path: Path) -> Table:
    """The table of the real arrays of a .mat file with as many rows as the longest one; fields of a struct are variables.

    An array (N, k) becomes the columns NAME_1 to NAME_k. Other variables are ignored. Raises InputError for a file of
    version 7.3 (HDF5), for what is no MATLAB file, and for a variable of more numbers than are kept in memory.
    """
    from scipy.io import whosmat

    with path.open("rb") as stream:
        head = stream.read(520)
    if HDF5 in (head[:8], head[512:520]):
        raise InputError(
            f"{path}: a MATLAB file of version 7.3, which is not read; save it again with save(..., '-v7')"
        )
    try:
        # the sizes that the file states or unpacks to, before anything of these sizes is kept
        listed = whosmat(str(path), appendmat=False)
        check_size(path, 1, len(listed))
        for name, shape, _ in listed:
            check_size(f"{path}, variable {name}", int(np.prod([float(k) for k in shape])), 1)
        _check_unpacked(path, head)
        found: dict[str, Array | None] = {}
        for name, _, _ in listed:
            found |= _numbers_in(path, name)
    except InputError:
        raise
    except Exception as error:  # broken bytes end in a dozen kinds of errors
        reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
        raise InputError(f"{path}: not readable as a MATLAB file ({reason}); {EXPECTED}") from None
    arrays = {name: value for name, value in found.items() if value is not None}
    rows = max((len(value) for value in arrays.values()), default=0)
    kept = {name: value for name, value in arrays.items() if len(value) == rows}
    if rows < 2:
        raise InputError(f"{path}: has no arrays of numbers; {EXPECTED}")
    if turned := [name for name, value in arrays.items() if value.ndim == 2 and value.shape[1] == rows > len(value)]:
        raise InputError(f"{path}: {turned[0]!r} is {arrays[turned[0]].shape}, expected ({rows}, n): transpose it")
    check_size(path, rows, sum(1 if value.ndim == 1 else value.shape[1] for value in kept.values()), MOST_CELLS)
    return table_of_arrays(kept, tuple(name for name in found if name not in kept))


def _check_unpacked(path: Path, head: bytes) -> None:
    """Raises InputError for a compressed variable that unpacks to more numbers than are kept in memory."""
    if not head.startswith(b"MATLAB 5.0"):
        return  # version 4 compresses nothing
    order = "<" if head[126:128] == b"IM" else ">"
    with path.open("rb") as stream:
        stream.seek(TEXT)
        while len(tag := stream.read(8)) == 8:
            kind, length = struct.unpack(f"{order}II", tag)
            if kind != COMPRESSED:
                stream.seek(length, os.SEEK_CUR)
                continue
            unpack, left, size = zlib.decompressobj(), length, 0
            while left > 0 and (block := stream.read(min(left, BLOCK))):
                left -= len(block)
                while block:
                    size += len(unpack.decompress(block, BLOCK))
                    block = unpack.unconsumed_tail
                    check_size(path, size // 8, 1)


def _numbers_in(path: Path, variable: str) -> dict[str, Array | None]:
    """The real arrays of a variable by their names, in a file where they are large, and None for its other content."""
    from scipy.io import loadmat

    content = loadmat(str(path), appendmat=False, struct_as_record=True, variable_names=[variable])
    fields = _fields(variable, content[variable]) if variable in content else {}
    return {name: _kept(_column(name, value)) if _is_numbers(value) else None for name, value in fields.items()}


def _kept(values: np.ndarray) -> Array:
    result = empty(values.shape)
    for rows in blocks(len(values)):
        result[rows] = values[rows]
    return result


def _fields(name: str, value: Any) -> dict[str, Any]:
    """The fields of a struct under their own names, or the variable."""
    if isinstance(value, np.ndarray) and value.dtype.names and value.size == 1:
        return {field: value[field].item() for field in value.dtype.names}
    return {name: value}


def _is_numbers(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.dtype.kind in "fiu" and value.ndim == 2 and value.size > 0


def _column(name: str, value: np.ndarray) -> np.ndarray:
    """A row or a column as (N,), but a channel of an arm of one joint as (N, 1); any other array as it is."""
    if 1 not in value.shape:
        return value
    return value.reshape(-1, 1) if name in CHANNELS else value.ravel()
