"""Text with columns, plain or gzip: read in blocks of bounded memory; broken rows are listed, not fatal."""

from __future__ import annotations

import gzip
import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from physident.errors import InputError
from physident.large_arrays import Growing, numbered
from physident.outputs import write_with
from physident.recordings.channels import BadRow
from physident.recordings.formats.table import MOST_CELLS, Table
from physident.recordings.formats.text_style import TextStyle, find_style

BLOCK = 4 << 20  # bytes
PRINTABLE = bytes(b if b in (9, 10, 13) or 32 <= b < 127 else 63 for b in range(256))
MAX_REJECTED = 100_000  # rows with a wrong number of fields: listing more would only fill the memory


def read_csv(path: Path) -> Table:
    """The table of a text file with commas, semicolons, tabs or spaces; a first row without any number is its header.

    Lines before it that begin with "#" are skipped, but the last of them is the header if no other is. Rows with a wrong
    number of fields are left out and listed; cells that are not numbers become NaN. Row numbers are line numbers. Raises
    InputError for a file that is empty, not text, a broken gzip, without columns, or too large.
    """
    style = find_style(path, _head(path))
    rejected: list[BadRow] = []
    values = _read(path, style, rejected)
    if not len(values) and not rejected:
        raise InputError(f"{path}: has no rows of {style.width} numbers under its first line; expected a recording")
    rows = numbered(len(values) + len(rejected), 1 + style.skipped)
    if rejected:
        rows = np.delete(rows, [bad.row - 1 - style.skipped for bad in rejected])
    return Table(values, rows, style.header, tuple(rejected))


def write_csv(path: str | Path, table: Table) -> None:
    """Write a table with its header as CSV, ten digits a number, whole or not at all."""
    header = ",".join(table.names or ())
    write_with(path, lambda file: np.savetxt(file, table.values, "%.10g", delimiter=",", header=header, comments=""))


def _read(path: Path, style: TextStyle, rejected: list[BadRow]) -> np.ndarray:
    """The rows (N, width) of numbers; those with another number of fields are added to ``rejected``."""
    rows = Growing(style.width)
    line, skip = style.skipped, style.skipped
    for text in _whole_lines(path):
        body = text
        while skip and body:
            body, skip = body.partition(b"\n")[2], skip - 1
        if not body:
            continue
        numbers, bad = _parse(path, style.with_commas(body), style, line)
        rows.add(numbers)
        rejected += bad
        line += len(numbers) + len(bad)
        if rows.rows * style.width > MOST_CELLS:
            raise InputError(f"{path}: more than {MOST_CELLS} numbers, expected a recording: cut it into parts")
        if len(rejected) > MAX_REJECTED:
            raise InputError(f"{path}: over {MAX_REJECTED} rows without {style.width} fields; expected a recording")
    return rows.table()


def _parse(path: Path, text: bytes, style: TextStyle, line: int) -> tuple[np.ndarray, list[BadRow]]:
    """Numbers (N, width) of whole lines of text, which follow ``line`` others, and the rows that are left out."""
    import pyarrow as pa
    from pyarrow import csv

    bad: list[BadRow] = []

    def invalid(row: Any) -> str:
        bad.append(BadRow(line + int(row.number), f"{row.actual_columns} fields, expected {row.expected_columns}"))
        return "skip"

    names = [str(i) for i in range(style.width)]
    read = csv.ReadOptions(use_threads=False, block_size=len(text) + 1, column_names=names)
    # every line is a row: a stray quote or an empty line must not shift the line numbers of the others
    parse = csv.ParseOptions(invalid_row_handler=invalid, quote_char=False, ignore_empty_lines=False)
    for kind in (pa.float64(), pa.binary()):  # cell by cell where some cell is no number
        bad.clear()
        convert = csv.ConvertOptions(
            column_types=dict.fromkeys(names, kind),
            null_values=["", "nan", "NaN", "null", "NA"],
            strings_can_be_null=True,
        )
        try:
            table = csv.read_csv(pa.BufferReader(text), read, parse, convert)
        except pa.ArrowInvalid as error:
            if "conversion error" in str(error) and kind == pa.float64():
                continue
            reason = str(error).splitlines()[0][:120]
            raise InputError(f"{path}: not readable as CSV ({reason}); expected rows of numbers") from None
        cells = (_numbers(c.to_pylist()) if kind == pa.binary() else c.to_numpy() for c in table.columns)
        return np.column_stack(list(cells)), bad
    raise AssertionError("cells read as bytes need no conversion")


def _whole_lines(path: Path) -> Iterator[bytes]:
    """The file in blocks that end with a line; bytes that are not ASCII text are read as "?", which is not a number."""
    carry = b""
    try:
        with gzip.open(path) if _is_gzip(path) else path.open("rb") as stream:
            while block := stream.read(BLOCK):
                if block.endswith(b"\r"):
                    block += stream.read(1)
                block = carry + block.replace(b"\r\n", b"\n").replace(b"\r", b"\n").translate(PRINTABLE)
                whole, newline, carry = block.rpartition(b"\n")
                if len(carry) > BLOCK:
                    raise InputError(
                        f"{path}: a line is longer than {BLOCK} characters, expected a row for each sample"
                    )
                if newline:
                    yield whole + newline
    except (OSError, EOFError, zlib.error) as error:
        reason = str(error)[:120]
        raise InputError(f"{path}: cannot be read ({reason}); expected a CSV, plain or gzip") from None
    if carry:
        yield carry


def _numbers(cells: list[bytes | None]) -> np.ndarray:
    return np.array([_number(cell.strip(b' "')) if cell is not None else np.nan for cell in cells])


def _number(cell: bytes) -> float:
    """The value of a cell, NaN for a text that is not a number; 1_000 is none, although Python accepts it."""
    try:
        return float(cell) if b"_" not in cell else np.nan
    except ValueError:
        return np.nan


def _is_gzip(path: Path) -> bool:
    with path.open("rb") as stream:
        return stream.read(2) == b"\x1f\x8b"


def _head(path: Path) -> bytes:
    """The beginning of the file, which must be text."""
    try:
        with gzip.open(path) if _is_gzip(path) else path.open("rb") as stream:
            head = stream.read(BLOCK)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path}: cannot be read ({error}); expected a CSV, plain or gzip") from None
    if not head:
        raise InputError(f"{path}: empty, expected comma-separated numbers")
    line, *rest = re.split(rb"[\r\n]", head, maxsplit=1)
    if b"\0" in line:
        kind = "UTF-16 text" if line.startswith((b"\xff\xfe", b"\xfe\xff")) else "not a text file"
        raise InputError(f"{path}: {kind}, expected comma-separated numbers in UTF-8")
    if not rest and len(head) == BLOCK:
        raise InputError(f"{path}: its first line is longer than {BLOCK} characters, expected one row for each sample")
    return head
