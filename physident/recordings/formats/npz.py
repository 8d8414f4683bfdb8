"""NumPy archives: arrays ``time`` (N,), ``q``, ``dq``, ``tau`` or ``current``, ``temperature`` (N, n), never pickled."""

from __future__ import annotations

import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from physident.errors import InputError
from physident.recordings.columns.header import CHANNELS
from physident.recordings.formats.table import MAX_CELLS, MAX_COLUMNS, Table


def read_npz(path: Path) -> Table:
    """The table of an .npz file; raises InputError for pickled, missing or ill-shaped arrays and archives too large."""
    try:
        with zipfile.ZipFile(path) as archive:
            found = [name.removesuffix(".npy") for name in archive.namelist()]
            wanted = [name for name in ("time", *CHANNELS) if name in found]
            shapes = {name: _shape(path, archive, name) for name in wanted}
            _check(path, shapes)
            arrays = [_array(archive, name) for name in wanted]
    except InputError:
        raise
    except Exception as error:  # the readers of archives and arrays raise a dozen kinds for one cause: broken bytes
        reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
        raise InputError(f"{path}: not an .npz archive of plain arrays ({reason}); write it by numpy.savez") from None
    names = ["time"]
    for name, (_, width) in list(shapes.items())[1:]:
        names += [f"{name}_{j}" for j in range(1, width + 1)]
    names += [name for name in found if name not in wanted]
    return Table(np.column_stack(arrays), np.arange(1, len(arrays[0]) + 1), tuple(names))


def _shape(path: Path, archive: zipfile.ZipFile, name: str) -> tuple[int, ...]:
    """The shape that an array's header states, before anything of its size is read."""
    with archive.open(f"{name}.npy") as stream:
        version = np.lib.format.read_magic(stream)
        header: Any = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }.get(version)
        if header is None:
            raise ValueError(f"{name!r} is of array format {version}, which is not known")
        shape, _, dtype = header(stream)
    if dtype.kind not in "fiu":
        raise InputError(f"{path}: {name!r} contains {dtype}, expected plain arrays of real numbers")
    return shape


def _check(path: Path, shapes: dict[str, tuple[int, ...]]) -> None:
    time = shapes.get("time")
    if time is None or len(time) != 1:
        raise InputError(f"{path}: 'time' is {'missing' if time is None else time}, expected an array (N,) [s]")
    for name, shape in shapes.items():
        if name != "time" and (len(shape) != 2 or shape[0] != time[0] or not 0 < shape[1] <= MAX_COLUMNS):
            raise InputError(f"{path}: {name!r} is {shape}, expected ({time[0]}, n) for n joints")
    if sum(map(math.prod, shapes.values())) > MAX_CELLS:
        raise InputError(f"{path}: unpacks to more than {MAX_CELLS} numbers: cut it into parts")


def _array(archive: zipfile.ZipFile, name: str) -> np.ndarray:
    with archive.open(f"{name}.npy") as stream:
        return np.asarray(np.lib.format.read_array(stream, allow_pickle=False), dtype=float)
