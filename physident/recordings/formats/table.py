"""What every reader returns: numbers, column names where the file has them, and the rows it could not read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.recordings.recording import BadRow

MAX_CELLS = 100_000_000  # 800 MB of numbers: an hour of a 7-joint arm at 1 kHz with every channel
MAX_COLUMNS = 1000


@dataclass(frozen=True)
class Table:
    """``values`` (N, C), unreadable cells NaN; ``rows`` (N,) each row's number in the file, from 1; ``names`` or None."""

    values: NDArray[np.float64]
    rows: NDArray[np.intp]
    names: tuple[str, ...] | None
    rejected: tuple[BadRow, ...] = ()
