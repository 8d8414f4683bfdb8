"""Designs our trajectories under the thesis' limits and under practical ones; run once, ``run.py`` reads what it kept."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any, Literal

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import physident as pid
from studies.thesis.halves import half
from studies.thesis.published import BASE_FREQUENCY, PERIODS

FOLDER = Path(__file__).parent
LIMITS: dict[str, Literal["joint", "all"]] = {
    "bse": "joint",
    "w": "joint",
    "whole, joint limits": "joint",
    "whole, all limits": "all",
}


def main() -> None:
    kept: dict[str, Any] = {}
    for name, limits in LIMITS.items():
        robot = half(name) if name in ("bse", "w") else pid.load_robot("ur5")
        found = pid.design_trajectory(robot, limits=limits, base_frequency=BASE_FREQUENCY, periods=PERIODS)
        print(
            f"{name}: cond(Y_B) {found.condition:.1f} after {found.seconds:.0f} s, processor {found.processor_seconds:.0f} s"
        )
        kept[name] = {
            "cond": found.condition,
            "columns": found.columns,
            "seconds": found.seconds,
            "processor_seconds": found.processor_seconds,
        }
        if name == "whole, all limits":
            found.trajectory.save(FOLDER / "designed.json")
    (FOLDER / "design.json").write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
