# fast: ten seconds
"""How long do all columns of the catalogue take on a minute of a 6-joint arm?"""

from __future__ import annotations

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import keep

import physident as pid

RATE, REPEATS = 125.0, 5


def main() -> None:
    robot = pid.load_robot("ur5")
    plan = pid.random_trajectory(robot, seed=1, harmonics=5, base_frequency=0.1, duration=60.0)
    clock, q, v, a = plan.sample(RATE)
    motion = pid.Signals(clock, q, v, a, rate=RATE, source="made")
    model = pid.Model.nominal(robot)
    filter = pid.Filter()
    seconds: dict[str, float] = {}
    count = 0
    for name, cls in pid.CATALOGUE.items():
        effect = cls.at_grid_middle(robot)
        signals = model.refer(motion)
        count += len(effect.columns(robot))
        best = float("inf")
        for _ in range(REPEATS):
            start = time.perf_counter()
            filter.apply(effect.values(robot, signals), RATE)
            best = min(best, time.perf_counter() - start)
        seconds[name] = best
    start = time.perf_counter()
    model.refer(motion)
    seconds["the model's own torque"] = time.perf_counter() - start
    total = sum(seconds.values())
    slowest = sorted(seconds.items(), key=lambda item: -item[1])[:5]
    rows = [
        f"{count} columns of {len(pid.CATALOGUE)} effects, {len(clock)} samples (60 s of a UR5), evaluated and filtered: {total:.2f} s (asked: 2)",
        "slowest: " + ", ".join(f"{name} {value:.3f} s" for name, value in slowest),
    ]
    keep(
        Path(__file__).parent,
        {"columns": count, "samples": len(clock), "seconds": seconds, "total": total},
        "\n".join(rows),
    )


if __name__ == "__main__":
    main()
