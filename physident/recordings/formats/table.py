"""What every reader returns: numbers, column names where the file has them, and the rows it could not read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.large_arrays import blocks, empty, numbered
from physident.recordings.channels import BadRow

MAX_CELLS = (
    100_000_000  # 800 MB of numbers that are in memory at once: an hour of a 7-joint arm at 1 kHz with every channel
)
MOST_CELLS = (
    4_000_000_000  # 32 GB of numbers in a file, for formats that are read in pieces: four days of a 6-joint arm
)
MAX_COLUMNS = 1000


@dataclass(frozen=True)
class Table:
    """``values`` (N, C), unreadable cells NaN; ``rows`` (N,) each row's number in the file, from 1; ``names`` or None.

    ``joints`` are the names of the joints 1 to n where the file has them.
    """

    values: NDArray[np.float64]
    rows: NDArray[np.intp]
    names: tuple[str, ...] | None
    rejected: tuple[BadRow, ...] = ()
    joints: tuple[str, ...] | None = None


def check_size(source: Any, rows: int, columns: int, most: int = MAX_CELLS) -> None:
    """Raises InputError for a table with more columns or numbers than any recording has; called before they are read."""
    if columns > MAX_COLUMNS:
        raise InputError(f"{source}: {columns} columns, expected at most {MAX_COLUMNS}: keep time, q, dq and effort")
    if rows * columns > most:
        raise InputError(f"{source}: more than {most} numbers, expected a recording: cut it into parts")


def table_of_arrays(arrays: Mapping[str, NDArray[Any]], others: tuple[str, ...] = ()) -> Table:
    """The table of arrays (N,) or (N, k) of numbers, which all have N rows; an array (N, k) becomes NAME_1 to NAME_k.

    ``others`` are names of what the file contains beside them.
    """
    names: list[str] = []
    for name, array in arrays.items():
        names += [name] if array.ndim == 1 else [f"{name}_{k}" for k in range(1, array.shape[1] + 1)]
    columns = [array.reshape(len(array), -1) for array in arrays.values()]
    values, start = empty((len(columns[0]), len(names))), 0
    for array in columns:
        for rows in blocks(len(array)):
            values[rows, start : start + array.shape[1]] = array[rows]
        start += array.shape[1]
    return Table(values, numbered(len(values)), (*names, *others))
