# fast: half a minute
"""How fast are the steps from signals to the compressed factor, against the plain way, in the same run?"""

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"  # before numpy loads: one core

import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from scipy.signal import filtfilt, lfilter

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import keep

import physident as pid
from physident.dynamics.rigid_body_regressor import torque_pattern

SAMPLES, RATE, LARGE = 20_000, 125.0, 1_000_000
REPEATS = 5


def make_signals(robot: pid.Robot, samples: int) -> pid.Signals:
    """Signals of a random Fourier motion with the nominal torque."""
    seconds = samples / RATE
    plan = pid.random_trajectory(
        robot, seed=1, harmonics=5, base_frequency=0.1, duration=round(seconds / 10 + 1) * 10.0
    )
    time, q, v, a = (x[:samples] for x in plan.sample(RATE))
    torque = np.zeros_like(q) if samples > SAMPLES else pid.Model.nominal(robot).torque(pid.Signals.of_states(q, v, a))
    return pid.Signals(time, q, v, a, torque, rate=RATE, source="made")


def plain_way(robot: pid.Robot, s: pid.Signals, filter: pid.Filter) -> tuple[np.ndarray, dict[str, float]]:
    """Pinocchio in a loop, filtfilt over all 360 columns, decimation, QR; and the seconds of each step."""
    clock = [time.perf_counter()]
    data = robot.pinocchio.createData()
    states = zip(s.q, s.v, s.a, strict=True)
    Y = np.array([pin.computeJointTorqueRegressor(robot.pinocchio, data, *state).copy() for state in states])
    clock.append(time.perf_counter())
    taps, D = filter.taps(RATE), filter.decimation(RATE)
    filtered = filtfilt(taps, 1.0, Y.reshape(len(Y), -1), axis=0)[::D]
    torque = filtfilt(taps, 1.0, s.torque, axis=0)[::D]
    clock.append(time.perf_counter())
    rows = np.column_stack([filtered.reshape(len(filtered) * robot.n, -1), torque.ravel()])
    R = np.asarray(np.linalg.qr(rows, mode="r"))
    clock.append(time.perf_counter())
    return R, dict(zip(("regressor", "filter", "factor"), np.diff(clock).tolist(), strict=True))


def our_way(robot: pid.Robot, effects: tuple[pid.Effect, ...], s: pid.Signals, filter: pid.Filter) -> Any:
    """From signals to the compressed factor."""
    return pid.build_regressor(robot, effects, [s], filter, moving_only=False).compressed(np.ones(robot.n))


def best(work: Callable[[], Any]) -> float:
    """The shortest of several runs [s]: what the machine can do when left alone."""
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def difference_from_scipy(
    robot: pid.Robot, effects: tuple[pid.Effect, ...], s: pid.Signals, filter: pid.Filter
) -> float:
    """Largest difference between our filtered regressor and scipy's lfilter with the same taps."""
    part = s.part(slice(0, 4000))
    regressor = pid.build_regressor(robot, effects, [part], filter, moving_only=False)
    taps = filter.taps(RATE)
    dense = effects[0].regressor(robot, part)
    theirs = np.asarray(lfilter(taps, 1.0, dense, axis=0))[len(taps) - 1 :][:: filter.decimation(RATE)]
    return float(np.abs(regressor.Y - theirs).max())


def large() -> None:
    """In a process of its own: a million samples, printing the largest resident size [MB]."""
    robot = pid.load_robot("ur5")
    signals = make_signals(robot, LARGE)
    our_way(robot, pid.make_effects(["rigid_body"]), signals, pid.Filter())
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)


def main() -> None:
    if sys.argv[1:] == ["large"]:
        large()
        return
    robot, filter = pid.load_robot("ur5"), pid.Filter()
    effects = pid.make_effects(["rigid_body"])
    s = make_signals(robot, SAMPLES)
    torque_pattern(robot)  # building the expression once is not part of a run
    _, steps = plain_way(robot, s, filter)
    for _ in range(REPEATS - 1):
        steps = {name: min(value, plain_way(robot, s, filter)[1][name]) for name, value in steps.items()}
    ours = best(lambda: our_way(robot, effects, s, filter))
    plain = sum(steps.values())
    memory = float(
        subprocess.run([sys.executable, __file__, "large"], capture_output=True, text=True, check=True).stdout
    )
    results = {
        "samples": SAMPLES,
        "plain_seconds": steps | {"total": plain},
        "our_seconds": ours,
        "ratio": plain / ours,
        "difference_from_scipy": difference_from_scipy(robot, effects, s, filter),
        "million_samples_MB": memory,
    }
    rows = [
        f"UR5, {SAMPLES} samples, one core, best of {REPEATS}, same run; seconds",
        "plain way: " + ", ".join(f"{name} {value:.3f}" for name, value in steps.items()) + f"; total {plain:.3f}",
        f"physident: {ours:.3f}; {plain / ours:.1f} times as fast (asked: 5)",
        f"largest difference from scipy's lfilter with the same taps: {results['difference_from_scipy']:.1e} (asked: 1e-9)",
        f"{LARGE} samples of 6 joints: {memory:.0f} MB resident at most (asked: 1000)",
    ]
    keep(Path(__file__).parent, results, "\n".join(rows))


if __name__ == "__main__":
    main()
