"""Archives, packed tables and other files that are no recording."""

from __future__ import annotations

import gzip
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from tests.bad_input.good import GOOD, Content, N, npz, table, write
from tests.bad_input.one_line_error import refused_recording


def half_npz(path: Path) -> None:
    buffer = io.BytesIO()
    np.savez(buffer, time=np.arange(9.0))
    path.write_bytes(buffer.getvalue()[: len(buffer.getvalue()) // 2])


def lying_npz(path: Path) -> None:
    """An archive whose array states a shape far larger than the data that follow."""
    head = b"\x93NUMPY\x01\x00"
    text = b"{'descr': '<f8', 'fortran_order': False, 'shape': (90000000000,), }"
    text += b" " * (117 - len(text)) + b"\n"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("time.npy", head + len(text).to_bytes(2, "little") + text + b"\0" * 800)


def _flipped(data: bytes) -> bytes:
    middle = len(data) // 2
    return data[:middle] + bytes(255 - b for b in data[middle : middle + 200]) + data[middle + 200 :]


FILES: dict[str, tuple[str, Content, str]] = {
    # name of the case: file, content, what the line must say
    "gz that is none": ("r.csv.gz", b"\x1f\x8b" + b"rubbish" * 50, "cannot be read|gzip"),
    "truncated gz": ("r.csv.gz", gzip.compress(GOOD.encode())[:-2000], "cannot be read|ended|truncated"),
    "gz with a broken body": ("r.csv.gz", lambda p: p.write_bytes(_flipped(gzip.compress(GOOD.encode()))), "gzip|read"),
    "empty gz": ("r.csv.gz", gzip.compress(b""), "empty"),
    "unknown ending": ("r.xlsx", GOOD, "format"),
    "no ending": ("r", GOOD, "format"),
}


@pytest.mark.parametrize("case", FILES)
def test_files(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    name, content, says = FILES[case]
    write(folder / name, content)
    refused_recording(capfd, folder, name, says)


NPZ: dict[str, tuple[Content, str]] = {
    "that is text": (GOOD, "npz"),
    "that is empty": ("", "npz"),
    "cut in half": (half_npz, "npz"),
    "with a lying header": (lying_npz, "unpacks to more"),
    "without time": (npz(time=None), "'time' is missing"),
    "without q": (npz(q=None), "no joint positions"),
    "pickled": (npz(q=np.array([{}, None] * (N // 2), dtype=object)[:, None]), "plain arrays"),
    "pickled time": (npz(time=np.array([object()] * N)), "plain arrays"),
    "complex": (npz(q=1j * table()[:, 1:7]), "complex"),
    "complex time": (npz(time=1j * table()[:, 0]), "complex"),
    "text": (npz(q=np.full((N, 6), "x")), "<U1"),
    "dates": (npz(time=np.arange(N).astype("datetime64[ms]")), "datetime64"),
    "one-dimensional q": (npz(q=table()[:, 1]), r"\(400,\)"),
    "q too short": (npz(q=table()[:50, 1:7]), r"\(50, 6\)"),
    "q transposed": (npz(q=table()[:, 1:7].T), r"\(6, 400\)"),
    "scalar time": (npz(time=np.array(1.0)), "time"),
    "two efforts": (npz(current=table()[:, 1:7]), "both tau and current"),
    "no joints": (npz(q=np.zeros((N, 0)), dq=None, tau=np.zeros((N, 0))), r"\(400, 0\)"),
    "no rows": (npz(time=np.zeros(0), q=np.zeros((0, 6)), dq=None, tau=np.zeros((0, 6))), "no rows|0 s"),
}


@pytest.mark.parametrize("case", NPZ)
def test_npz(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    content, says = NPZ[case]
    write(folder / "r.npz", content)
    refused_recording(capfd, folder, "r.npz", says)
