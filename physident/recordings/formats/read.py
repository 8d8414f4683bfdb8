"""The reader for a recording's file, chosen by the file's ending."""

from __future__ import annotations

import os
from pathlib import Path

from physident.errors import InputError
from physident.recordings.formats.table import Table


def read_table(path: Path) -> Table:
    """The table of a recording's file by its ending (.csv, .csv.gz, .txt, .npz); raises InputError for any other file."""
    name = path.name.lower()
    if not os.path.isfile(path):  # reading a pipe might never end
        problem = "a folder" if os.path.isdir(path) else "not a file" if os.path.exists(path) else "not found"
        raise InputError(f"recording {str(path)!r} is {problem}; expected a .csv, .csv.gz, .txt or .npz file")
    if name.endswith((".csv", ".csv.gz", ".txt")):
        from physident.recordings.formats.csv import read_csv

        return read_csv(path)
    if name.endswith(".npz"):
        from physident.recordings.formats.npz import read_npz

        return read_npz(path)
    raise InputError(f"{path}: its ending is of no known format; expected .csv, .csv.gz, .txt or .npz")
