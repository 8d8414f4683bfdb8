"""Small files that unpack to more than a machine holds: refused in bounded memory."""

from __future__ import annotations

import gzip
import io
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.io import savemat

from tests.bad_input.good import GOOD, HEADER
from tests.bad_input.one_line_error import assert_one_line, command


def gz_bomb(path: Path) -> None:
    """A hundred million empty cells in a hundred kilobytes."""
    many = (b"," * 999 + b"\n") * 10_000
    head = ",".join(f"c{i}" for i in range(1000)).encode() + b"\n"
    path.write_bytes(gzip.compress(head) + 11 * gzip.compress(many))


def gz_broken_rows(path: Path) -> None:
    """Fifty million rows, each of which would be named."""
    path.write_bytes(gzip.compress(GOOD.encode()) + 100 * gzip.compress(b"1,2\n" * 500_000))


def gz_line(path: Path) -> None:
    """A first line of one gigabyte, without an end."""
    path.write_bytes(64 * gzip.compress(b"1," * (8 << 20), 1))


def second_line(path: Path) -> None:
    """A good first line, and then one of a gigabyte."""
    path.write_bytes(gzip.compress(HEADER.encode() + b"\n") + 64 * gzip.compress(b"1," * (8 << 20), 1))


def zip_bomb(path: Path) -> None:
    """An array that states more numbers than any recording has, and 110,000,000 of them in under a megabyte."""
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("time.npy", "w", force_zip64=True) as stream,
    ):
        head = {"descr": "<f8", "fortran_order": False, "shape": (4_100_000_000,)}
        np.lib.format.write_array_header_1_0(stream, head)
        for _ in range(110):
            stream.write(bytes(8_000_000))


def sparse(path: Path) -> None:
    """Eight gigabytes of zeros that take no room on the disk."""
    with path.open("wb") as stream:
        stream.truncate(8 << 30)


def parquet_bomb(path: Path) -> None:
    """Lists of 110,000,000 equal numbers, each of which takes no room."""
    lists = pa.table({"q": pa.FixedSizeListArray.from_arrays(np.zeros(10_000_000), 1_000_000)})
    with pq.ParquetWriter(path, lists.schema) as writer:
        for _ in range(11):
            writer.write_table(lists)


def mat_bomb(path: Path) -> None:
    """A compressed struct of eight numbers, followed by a gigabyte of zeros."""
    buffer = io.BytesIO()
    savemat(buffer, {"run": {"q": np.zeros(8)}})
    head, element = buffer.getvalue()[:128], buffer.getvalue()[128:]
    packer = zlib.compressobj(1)
    content = packer.compress(struct.pack("<II", 14, len(element) - 8 + (1000 << 20)) + element[8:])
    content += b"".join(packer.compress(bytes(1 << 20)) for _ in range(1000)) + packer.flush()
    path.write_bytes(head + struct.pack("<II", 15, len(content)) + content)


BOMBS: dict[str, tuple[str, Callable[[Path], Any], str]] = {
    "gz bomb": ("r.csv.gz", gz_bomb, "no time column"),
    "gz bomb of broken rows": ("r.csv.gz", gz_broken_rows, "over 100000 rows"),
    "one line of a gigabyte": ("r.csv.gz", gz_line, "first line is longer"),
    "second line of a gigabyte": ("r.csv.gz", second_line, "a line is longer"),
    "parquet bomb": ("r.parquet", parquet_bomb, "1000000 columns, expected at most 1000"),
    "mat bomb": ("r.mat", mat_bomb, "more than 100000000 numbers"),
    "zip bomb": ("r.npz", zip_bomb, "unpacks to more"),
    "huge file of zeros": ("r.csv", sparse, "not a text file"),
    "huge model": ("m.json", sparse, "bytes"),
    "huge table": ("r.toml", sparse, "bytes"),
}


@pytest.mark.parametrize("case", BOMBS)
def test_bombs_in_bounded_memory(case: str, folder: Path) -> None:
    name, make, says = BOMBS[case]
    make(folder / name)
    arguments = {
        ".json": ["validate", "other.csv", "--model", name],
        ".toml": ["base-parameters", "--robot", name],
    }.get(Path(name).suffix, ["inspect", name])
    done = command(arguments, folder)
    assert_one_line(done.returncode, done.stdout, done.stderr, says)
