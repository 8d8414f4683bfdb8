"""NumPy archives: arrays ``time`` (N,), ``q``, ``dq``, ``tau`` or ``current``, ``temperature`` (N, n), never pickled."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

import numpy as np

from physident.columns import CHANNELS
from physident.errors import InputError
from physident.formats.table import MAX_CELLS, MAX_COLUMNS, Table


def read_npz(path: Path) -> Table:
    """The table of an .npz file; raises InputError for pickled, missing or ill-shaped arrays and archives too large."""
    try:
        with zipfile.ZipFile(path) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > 8 * MAX_CELLS:
                raise InputError(f"{path}: unpacks to more than {MAX_CELLS} numbers: cut it into parts")
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files if name in ("time", *CHANNELS)}
            others = [name for name in archive.files if name not in arrays]
    except (OSError, ValueError, zipfile.BadZipFile, zlib.error, EOFError) as error:
        raise InputError(f"{path}: not an .npz archive of plain arrays ({str(error).splitlines()[0][:120]})") from None
    time = arrays.pop("time", None)
    if time is None or time.ndim != 1:
        raise InputError(f"{path}: 'time' is {'missing' if time is None else time.shape}, expected an array (N,) [s]")
    names, parts = ["time"], [time[:, None]]
    for name, values in arrays.items():
        if (
            values.ndim != 2
            or len(values) != len(time)
            or values.shape[1] > MAX_COLUMNS
            or values.dtype.kind not in "fiu"
        ):
            raise InputError(f"{path}: {name!r} is {values.dtype} {values.shape}, expected numbers ({len(time)}, n)")
        names += [f"{name}_{j}" for j in range(1, values.shape[1] + 1)]
        parts.append(values)
    names += others
    values = np.concatenate([np.asarray(part, dtype=float) for part in parts], axis=1)
    return Table(values, np.arange(1, len(time) + 1), tuple(names))
