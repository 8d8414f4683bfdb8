"""The data set of a fleet: one Parquet file for each recording, with a row for each parameter, or one for what was wrong."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

from physident.errors import InputError
from physident.files import read_json, write_json
from physident.outputs import write_with
from physident.robots.robot import Robot

SCHEMA = "physident.fleet/1"
ROWS = "rows"  # folder of the Parquet files
BASELINES = "baselines"
BLOCK = 1 << 22  # bytes read at once
LARGEST_SETTINGS = 10_000_000  # bytes
TEXTS = ("arm", "file", "hash", "parameter", "effect", "unit", "finding", "error")
NUMBERS = (
    "value", "change", "std", "low", "high", "baseline", "information", "blocks", "temperature", "load", "seconds", "start",
)  # fmt: skip


@dataclass(frozen=True)
class FleetFolder:
    """The folder of a fleet's results: its data set, the arms' baselines and the settings that they were made with."""

    path: Path

    def part(self, digest: str) -> Path:
        """The Parquet file of a recording by the hash of its file."""
        return self.path / ROWS / f"{digest}.parquet"

    def baseline(self, arm: str) -> Path:
        """The model file of an arm's baseline."""
        return self.path / BASELINES / f"{arm}.json"

    def prepare(self, settings: dict[str, Any]) -> None:
        """Make the folder, or check that it was made with the same settings; raises InputError where it was not."""
        known = self.path / "fleet.json"
        if known.exists():
            before = read_json(known, LARGEST_SETTINGS, "the settings of a fleet", SCHEMA)
            if different := [key for key, value in settings.items() if before.get(key) != value]:
                raise InputError(
                    f"{self.path}: was made with another {', '.join(different)}; expected the same, or another --out"
                )
            return
        if self.path.exists() and (not self.path.is_dir() or any(self.path.iterdir())):
            raise InputError(f"{self.path}: is no folder of a fleet and not empty; expected another --out")
        try:
            for folder in (ROWS, BASELINES):
                (self.path / folder).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.path}: cannot be made ({error.strerror}); choose another --out") from None
        write_json(known, {"schema": SCHEMA, **settings})


def file_hash(path: str | Path) -> str:
    """Hash of a file's bytes; raises InputError for one that cannot be read."""
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as stream:
            while block := stream.read(BLOCK):
                digest.update(block)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); expected a recording") from None
    return digest.hexdigest()[:32]


def robot_hash(robot: Robot) -> str:
    """Hash of a robot's description."""
    import json

    return hashlib.sha256(json.dumps(robot.as_dict(), sort_keys=True).encode()).hexdigest()[:32]


def write_rows(path: Path, rows: Sequence[dict[str, Any]]) -> None:
    """Write the rows of one recording, whole or not at all."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    write_with(path, lambda file: pq.write_table(pa.Table.from_pylist(list(rows), schema=_schema()), file))


def read_rows(folder: Path) -> list[dict[str, Any]]:
    """All rows of a fleet, by arm and day; raises InputError for a folder without any."""
    import pyarrow as pa
    import pyarrow.dataset as ds

    files = sorted((folder / ROWS).glob("*.parquet"))
    if not files:
        raise InputError(f"{folder}: has no results of a fleet; expected the --out of physident fleet")
    try:
        table = ds.dataset([str(file) for file in files], schema=_schema()).to_table()
    except (pa.ArrowException, OSError) as error:
        reason = (str(error).splitlines() or [""])[0][:120]
        raise InputError(f"{folder}: its results cannot be read ({reason}); run physident fleet again") from None
    return sorted(table.to_pylist(), key=lambda row: (row["arm"], row["day"] or date.min, row["file"]))


def _schema() -> Any:
    import pyarrow as pa

    texts = [pa.field(name, pa.string()) for name in TEXTS]
    numbers = [pa.field(name, pa.float64()) for name in NUMBERS]
    return pa.schema(
        [
            *texts,
            pa.field("day", pa.date32()),
            pa.field("joint", pa.int32()),
            *numbers,
            pa.field("coupling", pa.list_(pa.float64())),
        ]
    )
