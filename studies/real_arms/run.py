"""What does diagnosis find on real arms? Six questions; `run.py a c` asks some of them anew, ten minutes for all."""

from __future__ import annotations

import json
import sys
import tempfile
import warnings
from importlib import import_module
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import keep, need_data

import physident as pid

HERE = Path(__file__).parent
PARTS = {
    "a": ("ur10e_structure", "UR10e: what the default model misses"),
    "b": ("ur10e_load", "UR10e: what is different when it carries a load"),
    "c": ("tx40_coupling", "TX40: what the default model misses"),
    "d": ("ur5_contact", "UR5: what is different when a hand pushes"),
    "e": ("ur5_nominal", "UR5: what a simulation from its description gets wrong"),
    "f": ("ur10e_rest", "UR10e: what an arm at rest shows"),
}


def main(wanted: list[str]) -> None:
    warnings.simplefilter("ignore", pid.PhysidentWarning)  # few independent samples: intervals say so
    for arm in ("ur10e", "ur5", "tx40"):
        need_data(arm)
    path = HERE / "results.json"
    results = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    with tempfile.TemporaryDirectory() as work:
        for letter in wanted or PARTS:
            name, question = PARTS[letter]
            found, rows = import_module(name).study(Path(work))
            results[letter] = found | {"question": question, "rows": rows}
            ordered = {key: results[key] for key in PARTS if key in results}
            titled = [[f"({key}) {part['question']}", "", *part["rows"]] for key, part in ordered.items()]
            keep(HERE, ordered, "\n\n\n".join("\n".join(text) for text in titled))


if __name__ == "__main__":
    main(sys.argv[1:])
