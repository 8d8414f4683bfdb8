"""NumPy archives: arrays ``time`` (N,), ``q``, ``dq``, ``tau`` or ``current``, ``temperature`` (N, n), read in pieces, never pickled."""

from __future__ import annotations

import math
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.large_arrays import blocks, empty, numbered
from physident.recordings.columns.header import CHANNELS
from physident.recordings.formats.table import MAX_COLUMNS, MOST_CELLS, Table

Array = NDArray[np.float64]


@dataclass(frozen=True)
class _Header:
    """What an array states of itself: ``shape``, whether it is stored column by column, and the type of its numbers."""

    shape: tuple[int, ...]
    by_column: bool
    dtype: np.dtype[Any]

    @property
    def size(self) -> int:
        """Bytes of the numbers."""
        return math.prod(self.shape) * self.dtype.itemsize


def read_npz(path: Path) -> Table:
    """The table of an .npz file; raises InputError for pickled, missing or ill-shaped arrays and archives too large."""
    try:
        with zipfile.ZipFile(path) as archive:
            found = [name.removesuffix(".npy") for name in archive.namelist()]
            wanted = [name for name in ("time", *CHANNELS) if name in found]
            headers = {name: _header(path, archive, name) for name in wanted}
            _check(path, {name: header.shape for name, header in headers.items()})
            if short := [name for name in wanted if archive.getinfo(f"{name}.npy").file_size < headers[name].size]:
                raise ValueError(f"{short[0]!r} has fewer numbers than it states")
            widths = [1 if name == "time" else headers[name].shape[1] for name in wanted]
            values, start = empty((headers["time"].shape[0], sum(widths))), 0
            for name, width in zip(wanted, widths, strict=True):
                _read(archive, name, headers[name], values[:, start : start + width])
                start += width
    except InputError:
        raise
    except Exception as error:  # the readers of archives and arrays raise a dozen kinds for one cause: broken bytes
        reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
        raise InputError(f"{path}: not an .npz archive of plain arrays ({reason}); write it by numpy.savez") from None
    names = ["time"]
    for name, width in zip(wanted[1:], widths[1:], strict=True):
        names += [f"{name}_{j}" for j in range(1, width + 1)]
    names += [name for name in found if name not in wanted]
    return Table(values, numbered(len(values)), tuple(names))


def _header(path: Path, archive: zipfile.ZipFile, name: str) -> _Header:
    """What an array states of itself, before anything of its size is read."""
    with archive.open(f"{name}.npy") as stream:
        header = _stated(stream, name)
    if header.dtype.kind not in "fiu":
        raise InputError(f"{path}: {name!r} contains {header.dtype}, expected plain arrays of real numbers")
    return header


def _stated(stream: IO[bytes], name: str) -> _Header:
    version = np.lib.format.read_magic(stream)
    read: Any = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }.get(version)
    if read is None:
        raise ValueError(f"{name!r} is of array format {version}, which is not known")
    return _Header(*read(stream))


def _check(path: Path, shapes: dict[str, tuple[int, ...]]) -> None:
    time = shapes.get("time")
    if time is None or len(time) != 1:
        raise InputError(f"{path}: 'time' is {'missing' if time is None else time}, expected an array (N,) [s]")
    for name, shape in shapes.items():
        if name != "time" and (len(shape) != 2 or shape[0] != time[0] or not 0 < shape[1] <= MAX_COLUMNS):
            raise InputError(f"{path}: {name!r} is {shape}, expected ({time[0]}, n) for n joints")
    if sum(map(math.prod, shapes.values())) > MOST_CELLS:
        raise InputError(f"{path}: unpacks to more than {MOST_CELLS} numbers: cut it into parts")


def _read(archive: zipfile.ZipFile, name: str, header: _Header, into: Array) -> None:
    """Read an array into the columns ``into`` (N, k) of the table, in blocks of rows, each column by itself where it is stored so."""
    parts = np.hsplit(into, into.shape[1]) if header.by_column else [into]
    with archive.open(f"{name}.npy") as stream:
        _stated(stream, name)
        for part in parts:
            for rows in blocks(len(part)):
                shape = part[rows].shape
                content = stream.read(math.prod(shape) * header.dtype.itemsize)
                part[rows] = np.frombuffer(content, header.dtype).reshape(shape)
