"""Sessions for the rerun viewer that ``view`` wrote (.rrd): they keep the recordings that they show."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from physident.errors import InputError
from physident.recordings.channels import printable
from physident.recordings.formats.table import Table, check_size, table_of_arrays

ROOT = "/recordings"  # entity of the recordings in a session, numbered from 0
CLOCK, JOINTS = "clock", "joints"
CHANNELS = ("q", "dq", "tau", "current", "effort", "temperature")


def parts_of_rrd(path: Path) -> list[str]:
    """The addresses of the recordings in a session: PATH#0 and so on."""
    return [f"{path}#{k}" for k in range(len(_recordings(path)))]


def read_rrd(path: Path, part: int | None) -> Table:
    """The table of one recording in a session, bit by bit as it was shown; raises InputError for another file or number."""
    found = _recordings(path)
    if (part or 0) not in found:
        raise InputError(f"{path}: has no recording {part}; expected 0 to {len(found) - 1}")
    content = found[part or 0]
    arrays = {name: content[name] for name in (CLOCK, *CHANNELS) if name in content}
    rows = len(arrays.get(CLOCK, ()))
    if not rows or any(len(values) % rows for values in arrays.values()):
        raise InputError(f"{path}: recording {part or 0} is not complete; expected a session that view wrote")
    arrays = {"time": arrays.pop(CLOCK)} | {name: values.reshape(rows, -1) for name, values in arrays.items()}
    check_size(path, rows, sum(values.size // rows for values in arrays.values()))
    table = table_of_arrays(arrays)
    joints = tuple(map(printable, content[JOINTS])) if JOINTS in content else None
    return Table(table.values, table.rows, table.names, joints=joints)


def _recordings(path: Path) -> dict[int, dict[str, Any]]:
    """The arrays of each recording by its number; raises InputError for a file without any."""
    level = os.environ.get("RUST_LOG")
    os.environ["RUST_LOG"] = "off"  # while it is loaded, or the library writes lines of its own about damaged files
    try:
        from rerun.chunk import RrdReader
    finally:
        os.environ.pop("RUST_LOG") if level is None else os.environ.update(RUST_LOG=level)
    found: dict[int, dict[str, Any]] = {}
    try:
        for chunk in RrdReader(str(path)).stream():
            place, _, number = str(chunk.entity_path).rpartition("/")
            if place == ROOT and number.isdigit():
                batch = chunk.to_record_batch()
                for label, column in zip(batch.schema.names, batch.columns, strict=True):
                    name = label.split(":")[-1]
                    if name in (CLOCK, JOINTS, *CHANNELS):
                        values = column[0].values.to_numpy(zero_copy_only=False)
                        kept = values if name == JOINTS else values.astype(float)
                        found.setdefault(int(number), {})[name] = kept
    except Exception as error:  # the reader is not ours and fails in kinds that it does not name
        reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
        raise InputError(f"{path}: not readable as a session ({reason}); expected one that view wrote") from None
    if not found:
        raise InputError(f"{path}: contains no recordings; expected a session that view wrote from recordings")
    return found
