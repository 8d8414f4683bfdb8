"""Apache Parquet: columns of numbers, and columns of lists of numbers, one for each joint."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.recordings.formats.frame import seconds
from physident.recordings.formats.table import Table, check_size, table_of_arrays


def read_parquet(path: Path) -> Table:
    """The table of a .parquet file; a column of lists of k numbers becomes NAME_1 to NAME_k, dates become seconds.

    Columns of another type are ignored. Raises InputError for what is no Parquet file, for lists of different lengths, and
    for a table too large.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path) as file:
            check_size(path, file.metadata.num_rows, file.metadata.num_columns)
            table = file.read(use_threads=False)
    except (pa.ArrowException, OSError, ValueError) as error:
        reason = (str(error).splitlines() or [""])[0][:120]
        raise InputError(f"{path}: not readable as Parquet ({reason}); expected a table of numbers") from None
    return table_of_columns(table, path)


def table_of_columns(table: Any, source: object) -> Table:
    """The table of an Arrow table; arguments of ``read_parquet``."""
    if not table.num_rows:
        raise InputError(f"{source}: has no rows; expected a recording")
    arrays, others = {}, []
    for name, column in zip(table.column_names, table.columns, strict=True):
        values = _numbers(column, name, source)
        if values is None:
            others.append(name)
        else:
            arrays[name] = values
    if not arrays:
        raise InputError(f"{source}: has no columns of numbers; expected a recording")
    check_size(source, table.num_rows, sum(1 if a.ndim == 1 else a.shape[1] for a in arrays.values()))
    return table_of_arrays(arrays, tuple(others))


def _numbers(column: Any, name: str, source: object) -> NDArray[np.float64] | None:
    """Values (N,) or (N, k) of an Arrow column, missing ones NaN; None for a column without numbers."""
    import pyarrow as pa
    import pyarrow.compute as pc

    kind = column.type
    if pa.types.is_timestamp(kind):
        return seconds(column.to_numpy())
    if pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind):
        return column.cast(pa.float64(), safe=False).to_numpy()
    if not (pa.types.is_list(kind) or pa.types.is_large_list(kind) or pa.types.is_fixed_size_list(kind)):
        return None
    inner = kind.value_type
    if not (pa.types.is_integer(inner) or pa.types.is_floating(inner)):
        return None
    lengths = pc.list_value_length(column).drop_null().unique().to_pylist()  # pyright: ignore[reportAttributeAccessIssue]
    if len(lengths) != 1 or not lengths[0] or column.null_count:
        raise InputError(
            f"{source}: column {name!r} has lists of different lengths; expected one number for each joint"
        )
    flat = pc.list_flatten(column).cast(pa.float64(), safe=False)  # pyright: ignore[reportAttributeAccessIssue]
    return flat.to_numpy().reshape(-1, lengths[0])
