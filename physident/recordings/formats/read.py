"""The reader for a recording's file, chosen by the file's ending; ``FORMATS`` registers one format a line."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from physident.errors import InputError
from physident.recordings.columns.reading import Reading
from physident.recordings.formats.table import Table


@dataclass(frozen=True, kw_only=True)
class Format:
    """A format of recordings: its ``reader`` is ``read_NAME(path, ...)`` of the module NAME in this folder.

    ``endings`` of its files, ``marks`` the files that a folder of the format contains (patterns), ``options`` the fields of
    ``Reading`` that its reader takes, ``parts`` whether one file contains several recordings: ``parts_of_NAME(path)`` are
    then their addresses, PATH#K.
    """

    name: str
    endings: tuple[str, ...] = ()
    marks: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    parts: bool = False

    def function(self, verb: str) -> Callable[..., Any]:
        """A function of the format's module, imported on first use."""
        return getattr(import_module(f"physident.recordings.formats.{self.name}"), f"{verb}_{self.name}")


FORMATS = (
    Format(name="csv", endings=(".csv", ".csv.gz", ".txt")),
    Format(name="npz", endings=(".npz",)),
    Format(name="parquet", endings=(".parquet",)),
    Format(name="mat", endings=(".mat",)),
    Format(
        name="rosbag",
        endings=(".db3", ".mcap"),
        marks=("metadata.yaml", "*.db3", "*.mcap"),
        options=("topic", "wanted_joints"),
    ),
    Format(name="lerobot", marks=("meta/info.json",), options=("columns",), parts=True),
    Format(name="rrd", endings=(".rrd",), parts=True),
)
ENDINGS = ", ".join(ending for one in FORMATS for ending in one.endings)
EXPECTED = f"a file ({ENDINGS}), a folder of a ROS 2 bag, or a LeRobot data set"


def read_table(path: str | Path, reading: Reading | None = None) -> Table:
    """The table of a recording's file or folder, or of one part, PATH#K; raises InputError for any other."""
    reading = reading or Reading()
    file = Path(path)
    place, part = _split(str(path))
    known = _format(place, str(path))
    if reading.topic is not None and "topic" not in known.options:
        raise InputError(f"{path}: has no topics, but the topic {reading.topic!r} is given; expected a ROS 2 bag")
    options = {name: getattr(reading, name) for name in known.options}
    if known.parts:
        return known.function("read")(Path(place), part, **options)
    return known.function("read")(file, **options)


def parts_of(path: str) -> list[str]:
    """The recordings in a file or folder: itself, or the address PATH#K of each part, counted from 0."""
    place, part = _split(path)
    if part is not None or not os.path.exists(place):
        return [path]
    try:
        known = _format(place, path)
    except InputError:
        return [path]
    return known.function("parts_of")(Path(path)) if known.parts else [path]


def is_there(path: str | Path) -> bool:
    """Whether a path, or the file or folder of an address PATH#K, exists."""
    return os.path.exists(_split(str(path))[0])


def _split(path: str) -> tuple[str, int | None]:
    """The path and the number of a part in an address PATH#K; a file that has this very name comes first."""
    place, mark, part = path.rpartition("#")
    if not mark or not part.isascii() or not part.isdigit() or len(part) > 9 or os.path.exists(path):
        return path, None
    return place, int(part)


def _format(place: str, path: str) -> Format:
    if os.path.isdir(place):
        folder = Path(place)
        for known in FORMATS:
            if any(next(folder.glob(mark), None) is not None for mark in known.marks):
                return known
        raise InputError(f"recording {path!r} is a folder without a recording; expected {EXPECTED}")
    if not os.path.isfile(place):  # reading a pipe might never end
        problem = "not a file" if os.path.exists(place) else "not found"
        raise InputError(f"recording {path!r} is {problem}; expected {EXPECTED}")
    for known in FORMATS:
        if place.lower().endswith(known.endings) and known.endings:
            return known
    raise InputError(f"{path}: its ending is of no known format; expected {ENDINGS}")
