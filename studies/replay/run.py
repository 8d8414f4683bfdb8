"""What does a diagnosis gain in the simulator? Five questions; `run.py a` asks some of them anew."""

from __future__ import annotations

import json
import sys
import warnings
from importlib import import_module
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import keep

import physident as pid

HERE = Path(__file__).parent
PARTS = {
    "a": ("ur10e", "UR10e, a run that nobody fitted: 0.5 s ahead, before and after the diagnosis"),
    "b": ("hidden", "A MuJoCo arm with a hidden effect, diagnosed and corrected in its MJCF"),
    "c": ("code", "Generated C code: its error, and its speed beside Pinocchio"),
    "d": ("exports", "UR10e: the torque that each exported file has, on the training recordings"),
    "e": ("mujoco_sysid", "The same parameters from the same simulated recording, by physident and by mujoco.sysid"),
}


def main(wanted: list[str]) -> None:
    warnings.simplefilter("ignore", pid.PhysidentWarning)
    path = HERE / "results.json"
    for letter in wanted or PARTS:
        name, question = PARTS[letter]
        found, rows = import_module(name).study()
        results = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        results[letter] = found | {"question": question, "rows": rows}
        ordered = {key: results[key] for key in PARTS if key in results}
        titled = [[f"({key}) {part['question']}", "", *part["rows"]] for key, part in ordered.items()]
        keep(HERE, ordered, "\n\n\n".join("\n".join(text) for text in titled))


if __name__ == "__main__":
    main(sys.argv[1:])
