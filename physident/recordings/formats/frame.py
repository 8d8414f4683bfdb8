"""Frames of pandas and polars, in memory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.recordings.formats.table import Table, check_size, table_of_arrays

if TYPE_CHECKING:
    import pandas as pd


def table_of_frame(frame: Any, source: str) -> Table:
    """The table of a pandas or polars frame; a column of dates becomes seconds, one that is not numeric is ignored.

    Raises InputError for what is no frame or has no numbers.
    """
    if not hasattr(frame, "columns") or not hasattr(frame, "__getitem__"):
        raise InputError(f"{source}: {type(frame).__name__}, expected a pandas or polars frame")
    check_size(source, len(frame), len(frame.columns))
    arrays, others = {}, []
    for name in frame.columns:
        values = frame[name].to_numpy()
        if values.dtype.kind == "M":
            arrays[str(name)] = seconds(values)
        elif values.dtype.kind in "fiu":
            arrays[str(name)] = values
        else:
            others.append(str(name))
    if not arrays or not len(frame):
        raise InputError(f"{source}: a frame without numbers, expected the rows of a recording")
    return table_of_arrays(arrays, tuple(others))


def seconds(dates: NDArray[Any]) -> NDArray[np.float64]:
    """Seconds (N,) since 1970 of dates (N,), NaN for those that are missing."""
    whole = dates.astype("datetime64[ns]")
    return np.where(np.isnat(whole), np.nan, whole.astype(np.int64) / 1e9)


def frame_of(time: NDArray[np.float64], channels: Mapping[str, NDArray[np.float64] | None]) -> pd.DataFrame:
    """A pandas frame of ``time`` (N,) and channels (N, n), whose columns are numbered from 1; raises InputError without pandas."""
    try:
        import pandas as pd
    except ImportError:
        raise InputError("pandas is not installed, expected it for a frame: pip install pandas") from None
    columns = {"time": time}
    for name, values in channels.items():
        if values is not None:
            columns |= {f"{name}_{j}": column for j, column in enumerate(values.T, 1)}
    return pd.DataFrame(columns)
