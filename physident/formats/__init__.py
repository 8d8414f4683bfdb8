"""File formats of recordings, one small file each; every reader returns a ``Table``."""

from __future__ import annotations

from pathlib import Path

from physident.errors import InputError
from physident.formats.table import Table


def read_table(path: Path) -> Table:
    """The table of a recording's file by its ending: .csv, .csv.gz, .npz; raises InputError for any other."""
    name = path.name.lower()
    if name.endswith((".csv", ".csv.gz", ".txt")):
        from physident.formats.csv import read_csv

        return read_csv(path)
    if name.endswith(".npz"):
        from physident.formats.npz import read_npz

        return read_npz(path)
    raise InputError(f"{path}: its format is not known by its name; expected .csv, .csv.gz or .npz")
