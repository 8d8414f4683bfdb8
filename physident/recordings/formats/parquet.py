"""Apache Parquet: columns of numbers, and columns of lists of numbers, one for each joint."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.large_arrays import Growing, numbered
from physident.recordings.formats.frame import seconds
from physident.recordings.formats.table import MAX_CELLS, MOST_CELLS, Table, check_size, table_of_arrays

BATCH = 1 << 16  # rows read at once


def read_parquet(path: Path) -> Table:
    """The table of a .parquet file, read in batches; a column of lists of k numbers becomes NAME_1 to NAME_k, dates become seconds.

    Columns of another type are ignored. Raises InputError for what is no Parquet file, for lists of different lengths, and
    for a table too large.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    names: tuple[str, ...] | None = None
    rows: Growing | None = None
    with _readable(path), pq.ParquetFile(path, pre_buffer=False, buffer_size=1 << 20) as file:
        chosen, others = _columns_of(file, path, MOST_CELLS)
        for batch in file.iter_batches(BATCH, columns=chosen, use_threads=False):
            some = table_of_columns(pa.Table.from_batches([batch]), path, others)
            if names is not None and some.names != names:
                raise InputError(f"{path}: has lists of different lengths; expected one number for each joint")
            names, rows = some.names, rows or Growing(some.values.shape[1])
            rows.add(some.values)
        if rows is None:
            return table_of_columns(file.schema_arrow.empty_table().select(chosen), path, others)
    values = rows.table()
    return Table(values, numbered(len(values)), names)


def read_columns(path: Path, filters: list[tuple[str, str, int]] | None = None) -> tuple[Any, tuple[str, ...]]:
    """The Arrow table of the columns of numbers, and the names of the others; ``filters`` choose rows.

    Raises InputError as ``read_parquet``, but for the content of the columns.
    """
    import pyarrow.parquet as pq

    with _readable(path):
        with pq.ParquetFile(path) as file:
            names, others = _columns_of(file, path, MAX_CELLS)
        # a folder named a=1 must not become a column
        chosen = {"columns": names, "filters": filters, "use_threads": False, "partitioning": None}
        return pq.read_table(path, **chosen), others


def _columns_of(file: Any, path: Path, most: int) -> tuple[list[str], tuple[str, ...]]:
    """The names of the columns of numbers and of the others; raises InputError for more than ``most`` numbers."""
    names = [field.name for field in file.schema_arrow if _is_read(field.type)]
    rows = max(1, file.metadata.num_rows)
    check_size(path, rows, math.ceil(sum(_sizes(file.metadata, names)) / rows), most)
    return names, tuple(name for name in file.schema_arrow.names if name not in names)


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    """Turns what Arrow says of a broken file into an InputError."""
    import pyarrow as pa

    try:
        yield
    except (pa.ArrowException, OSError, ValueError, KeyError) as error:
        reason = (str(error).splitlines() or [""])[0][:120]
        raise InputError(f"{path}: not readable as Parquet ({reason}); expected a table of numbers") from None


def table_of_columns(columns: Any, source: object, others: tuple[str, ...] = ()) -> Table:
    """The table of an Arrow table of numbers, lists of numbers and dates; ``others`` are the columns that were not read."""
    if not columns.num_columns:
        raise InputError(f"{source}: has no columns of numbers; expected a recording")
    if not columns.num_rows:
        raise InputError(f"{source}: has no rows; expected a recording")
    named = zip(columns.column_names, columns.columns, strict=True)
    arrays = {name: _numbers(column, name, source) for name, column in named}
    check_size(source, columns.num_rows, sum(1 if array.ndim == 1 else array.shape[1] for array in arrays.values()))
    return table_of_arrays(arrays, others)


def _sizes(metadata: Any, names: Sequence[str]) -> Iterator[int]:
    """Count of the numbers in each part of the columns, list by list."""
    for group in range(metadata.num_row_groups):
        for place in range(metadata.num_columns):
            column = metadata.row_group(group).column(place)
            if any(f"{column.path_in_schema}.".startswith(f"{name}.") for name in names):
                yield column.num_values


def _is_read(kind: Any) -> bool:
    """Whether an Arrow type is that of numbers, dates or lists of numbers."""
    import pyarrow as pa

    if pa.types.is_list(kind) or pa.types.is_large_list(kind) or pa.types.is_fixed_size_list(kind):
        return pa.types.is_integer(kind.value_type) or pa.types.is_floating(kind.value_type)
    return pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_timestamp(kind)


def _numbers(column: Any, name: str, source: object) -> NDArray[np.float64]:
    """Values (N,) or (N, k) of an Arrow column, missing ones NaN."""
    import pyarrow as pa
    import pyarrow.compute as pc

    if pa.types.is_timestamp(column.type):
        return seconds(column.to_numpy())
    if not pa.types.is_nested(column.type):
        return column.cast(pa.float64(), safe=False).to_numpy()
    lengths = pc.list_value_length(column).unique().to_pylist()  # pyright: ignore[reportAttributeAccessIssue]
    if len(lengths) != 1 or not lengths[0]:
        raise InputError(
            f"{source}: column {name!r} has lists of different lengths; expected one number for each joint"
        )
    flat = pc.list_flatten(column).cast(pa.float64(), safe=False)  # pyright: ignore[reportAttributeAccessIssue]
    return flat.to_numpy().reshape(-1, lengths[0])
