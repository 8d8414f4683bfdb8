"""Comma-separated text, plain or gzip: read in blocks, bounded in memory, broken rows named instead of fatal."""

from __future__ import annotations

import gzip
import re
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from physident.errors import InputError
from physident.files import write_with
from physident.formats.table import MAX_CELLS, MAX_COLUMNS, Table
from physident.recording import BadRow

BLOCK = 4 << 20  # bytes
SEPARATORS = {";": "semicolon", "\t": "tab"}
MAX_REJECTED = (
    100_000  # rows with a wrong number of fields: naming more would fill the memory, and tell nobody anything
)


def read_csv(path: Path) -> Table:
    """The table of a CSV file; a first row without any number is its header.

    Rows with a wrong number of fields are left out and named, cells that are no number become NaN. Row numbers are line
    numbers. Raises InputError for a file that is empty, not text, no gzip, without commas, or too large.
    """
    first = _first_line(path)
    fields = [field.strip().strip('"') for field in first.split(",")]
    if len(fields) < 2:
        found = next((f", but has {name}s" for sign, name in SEPARATORS.items() if sign in first), "")
        raise InputError(f"{path}: its first line has no comma{found}; expected comma-separated columns: convert it")
    if len(fields) > MAX_COLUMNS:
        raise InputError(f"{path}: {len(fields)} columns, expected at most {MAX_COLUMNS}: keep time, q, dq and effort")
    header = not any(_is_number(field) for field in fields)
    rejected: list[BadRow] = []
    try:
        values = _read(path, len(fields), header, rejected, as_text=False)
    except _NotNumeric:
        rejected.clear()
        values = _read(path, len(fields), header, rejected, as_text=True)
    if not len(values) and not rejected:
        raise InputError(f"{path}: has no rows of {len(fields)} numbers under its first line; expected a recording")
    numbers = np.arange(1 + header, 1 + header + len(values) + len(rejected))
    rows = np.delete(numbers, [bad.row - 1 - header for bad in rejected])
    return Table(values, rows, tuple(fields) if header else None, tuple(rejected))


def write_csv(path: str | Path, table: Table) -> None:
    """Write a table with its header as CSV, ten digits a number, whole or not at all."""
    header = ",".join(table.names or ())
    write_with(path, lambda file: np.savetxt(file, table.values, "%.10g", delimiter=",", header=header, comments=""))


class _NotNumeric(Exception):
    """Some cell is no number: the file must be read again as text, cell by cell."""


def _read(path: Path, width: int, header: bool, rejected: list[BadRow], as_text: bool) -> np.ndarray:
    import pyarrow as pa
    from pyarrow import csv

    def invalid(row: Any) -> str:
        rejected.append(BadRow(int(row.number), f"{row.actual_columns} fields, expected {row.expected_columns}"))
        return "skip" if len(rejected) <= MAX_REJECTED else "error"

    names = [str(i) for i in range(width)]
    kind = pa.binary() if as_text else pa.float64()
    convert = csv.ConvertOptions(
        column_types=dict.fromkeys(names, kind), null_values=["", "nan", "NaN", "null", "NA"], strings_can_be_null=True
    )
    # line numbers are only counted by the single-threaded reader
    read = csv.ReadOptions(use_threads=False, block_size=BLOCK, column_names=names, skip_rows=int(header))
    # every line is a row, whatever it holds: an odd quote or an empty line must not shift the numbers of the others
    parse = csv.ParseOptions(invalid_row_handler=invalid, quote_char=False, ignore_empty_lines=False)
    blocks: list[np.ndarray] = []
    cells = 0
    try:
        with pa.input_stream(str(path), compression="gzip" if _is_gzip(path) else None) as stream:
            for batch in csv.open_csv(stream, read_options=read, parse_options=parse, convert_options=convert):
                cells += batch.num_rows * width
                if cells > MAX_CELLS:
                    raise InputError(f"{path}: more than {MAX_CELLS} numbers, expected a recording: cut it into parts")
                columns = [
                    _numbers(column.to_pylist()) if as_text else column.to_numpy(zero_copy_only=False)
                    for column in batch.columns
                ]
                blocks.append(np.column_stack(columns))
    except pa.ArrowInvalid as error:
        if "conversion error" in str(error) and not as_text:
            raise _NotNumeric from None
        if "skip initial" in str(error):  # a header, and not even the end of its line
            return np.empty((0, width))
        if len(rejected) > MAX_REJECTED:
            raise InputError(f"{path}: over {MAX_REJECTED} rows without {width} fields; expected a recording") from None
        raise InputError(
            f"{path}: not readable as CSV ({str(error).splitlines()[0][:120]}); expected rows of numbers"
        ) from None
    except (OSError, zlib.error) as error:
        raise InputError(
            f"{path}: cannot be read ({str(error).splitlines()[0][:120]}); expected a CSV, plain or gzip"
        ) from None
    return _joined(blocks, cells // width, width)


def _joined(blocks: list[np.ndarray], rows: int, width: int) -> np.ndarray:
    """The blocks one under another, each given back as soon as it is copied: the table is never held twice."""
    values = np.empty((rows, width))
    at = rows
    while blocks:
        block = blocks.pop()
        values[at - len(block) : at] = block
        at -= len(block)
    return values


def _numbers(cells: list[bytes | None]) -> np.ndarray:
    return np.array([_number(cell.strip(b' "')) if cell is not None else np.nan for cell in cells])


def _number(cell: bytes) -> float:
    """The value of a cell, NaN where it is none; Python's own 1_000 is none."""
    try:
        return float(cell) if b"_" not in cell else np.nan
    except ValueError:
        return np.nan


def _is_number(text: str) -> bool:
    return text.lower() in ("nan", "") or not np.isnan(_number(text.encode()))


def _is_gzip(path: Path) -> bool:
    with path.open("rb") as stream:
        return stream.read(2) == b"\x1f\x8b"


def _first_line(path: Path) -> str:
    """The first line, read without trusting the file to have a short one."""
    try:
        with gzip.open(path) if _is_gzip(path) else path.open("rb") as stream:
            head = stream.read(BLOCK)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path}: cannot be read ({error}); expected a CSV, plain or gzip") from None
    line, *rest = re.split(rb"[\r\n]", head, maxsplit=1)
    if not head:
        raise InputError(f"{path}: empty, expected comma-separated numbers")
    if b"\0" in line:
        kind = "UTF-16 text" if line.startswith((b"\xff\xfe", b"\xfe\xff")) else "not a text file"
        raise InputError(f"{path}: {kind}, expected comma-separated numbers in UTF-8")
    if not rest and len(head) == BLOCK:
        raise InputError(f"{path}: its first line is longer than {BLOCK} characters, expected one row for each sample")
    try:
        return line.decode("utf-8-sig").strip()
    except UnicodeDecodeError:
        raise InputError(f"{path}: its first line is not UTF-8 text, expected comma-separated numbers") from None
