# fast: half a minute
"""How long does a session take to write, and how large is it: one minute and ten of a 6-joint arm, two models?"""

from __future__ import annotations

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import numpy as np
from kept import keep

import physident as pid

RATE, REPEATS, NOISE = 125.0, 3, 0.5
EXTENDED = (
    "rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction", "torque_offset",
    "load_dependent_friction", "friction_asymmetry",
)  # fmt: skip


def recorded(robot: pid.Robot, duration: float) -> pid.Recording:
    """A motion of the arm with torques of its nominal model and noise: the numbers do not matter, their count does."""
    plan = pid.random_trajectory(robot, seed=1, harmonics=5, base_frequency=0.1, duration=duration)
    clock, q, v, a = plan.sample(RATE)
    torque = pid.Model.nominal(robot).torque(pid.Signals(clock, q, v, a, rate=RATE))
    torque = torque + NOISE * np.random.default_rng(0).standard_normal(torque.shape)
    return pid.Recording(clock, q, torque, "torque", dq=v, source="made")


def main() -> None:
    import rerun  # noqa: F401  # its import is measured apart

    robot = pid.load_robot("ur5")
    minute, ten = recorded(robot, 60.0), recorded(robot, 600.0)
    models = {"default": pid.identify(robot, [minute]), "extended": pid.identify(robot, [minute], effects=EXTENDED)}
    results: dict[str, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, recording in (("one minute", minute), ("ten minutes", ten)):
            path = Path(folder, "session.rrd")
            best = clock = float("inf")
            for _ in range(REPEATS):
                start, began = time.process_time(), time.perf_counter()
                pid.view(models, replace(recording), to=path)
                best = min(best, time.process_time() - start)
                clock = min(clock, time.perf_counter() - began)
            size = path.stat().st_size / 1e6
            results[name] = {"processor": best, "clock": clock, "megabytes": size, "samples": len(recording.time)}
    asked = {"one minute": "2 s", "ten minutes": "50 MB"}
    rows = [f"{'':<14}{'samples':>9}{'processor [s]':>15}{'clock [s]':>11}{'size [MB]':>11}   asked"]
    rows += [
        f"{name:<14}{int(r['samples']):>9}{r['processor']:>15.2f}{r['clock']:>11.2f}{r['megabytes']:>11.1f}   under {asked[name]}"
        for name, r in results.items()
    ]
    keep(Path(__file__).parent, results, "\n".join(rows))


if __name__ == "__main__":
    main()
