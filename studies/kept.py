"""What every study does at its end: print its table, keep its results, put the table into its README."""

from __future__ import annotations

import json
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: small matrices, and a machine that is shared

import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
DATA = Path(os.environ.get("PHYSIDENT_DATA", ROOT / ".." / "shared" / "data"))
UR10E_COLUMNS = "time=0,q=1:7,dq=7:13,current=13:19"
UR10E_GAINS = (14.87, 13.26, 11.13, 10.62, 11.03, 11.47)  # N m/A, the literature's
UR5_GAINS = (10.7, 10.7, 10.7, 10.2, 10.2, 10.2)  # N m/A, the controller's own


def need_data(folder: str) -> Path:
    """The folder of an arm's real recordings; ends the study with one line where it is absent."""
    path = DATA / folder
    if not path.is_dir():
        sys.exit(f"no recordings in {path}: set PHYSIDENT_DATA to the folder that holds {folder}/")
    return path


def keep(folder: Path, results: dict[str, Any], table: str) -> None:
    """Write results.json, print the table, and replace the marked block of the study's README with it."""
    (folder / "results.json").write_text(json.dumps(results, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    print(table)
    readme = folder / "README.md"
    block = f"<!-- results -->\n```\n{table}\n```\n<!-- /results -->"
    text = readme.read_text(encoding="utf-8")
    changed, count = re.subn(r"<!-- results -->.*?<!-- /results -->", lambda _: block, text, flags=re.S)
    if count != 1:
        sys.exit(f"{readme}: {count} blocks between <!-- results --> marks, expected one")
    readme.write_text(changed, encoding="utf-8")


def joint_row(label: str, values: Any, digits: int = 2) -> str:
    """One row of a table with a number for each joint."""
    return f"{label:<44}" + "".join(f"{v:9.{digits}f}" for v in values)
