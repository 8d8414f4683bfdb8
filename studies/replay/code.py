"""The C code of a UR5 with friction: its largest error, and the processor time of one call beside Pinocchio's."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import pinocchio as pin

import physident as pid

CALLS = 1_000_000
MAIN = """
#include <time.h>
double physident_time(int calls) {
  double q[6] = {.1, .2, .3, .4, .5, .6}, v[6] = {.1, .2, .3, .4, .5, .6}, a[6] = {.1, .2, .3, .4, .5, .6}, tau[6];
  struct timespec s, e;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &s);
  for (int k = 0; k < calls; k++) { physident_torque(q, v, a, tau); q[0] = 1e-9 * tau[0] + 1e-7 * k; }
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &e);
  return ((e.tv_sec - s.tv_sec) + 1e-9 * (e.tv_nsec - s.tv_nsec)) / calls;
}
"""


def study() -> tuple[dict, list[str]]:
    robot = pid.load_robot("ur5")
    model = pid.Model.nominal(robot)
    rng = np.random.default_rng(0)
    q, v, a = rng.uniform(-2, 2, size=(3, 1000, 6))
    expected = model.torque(pid.Signals.of_states(q, v, a))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "torque.c")
        pid.export_c(model, path)
        path.write_text("#define _POSIX_C_SOURCE 199309L\n" + path.read_text() + MAIN)
        command = [
            "cc",
            "-O2",
            "-march=native",
            "-std=c99",
            "-shared",
            "-fPIC",
            "-o",
            f"{folder}/t.so",
            str(path),
            "-lm",
        ]
        subprocess.run(command, check=True, timeout=300)
        library = ctypes.CDLL(f"{folder}/t.so")
        library.physident_time.restype = ctypes.c_double
        pointer = ctypes.POINTER(ctypes.c_double)
        found, tau = np.zeros_like(expected), np.zeros(6)
        for k in range(1000):
            library.physident_torque(*(x.ctypes.data_as(pointer) for x in (q[k], v[k], a[k], tau)))
            found[k] = tau
        own = min(library.physident_time(CALLS) for _ in range(5))
    data = robot.pinocchio.createData()
    best = np.inf
    for _ in range(5):
        start = time.process_time()
        for _ in range(20_000):
            pin.rnea(robot.pinocchio, data, q[0], v[0], a[0])
        best = min(best, (time.process_time() - start) / 20_000)
    error = float(np.abs(found - expected).max() / np.abs(expected).max())
    results = {"error": error, "c_us": 1e6 * own, "pinocchio_us": 1e6 * best}
    return results, [
        f"largest error of the C code's torque, of the largest torque   {error:.1e}",
        f"one call of the C code, with friction                       {1e6 * own:7.2f} us",
        f"one call of Pinocchio's rnea through Python, bodies alone   {1e6 * best:7.2f} us",
    ]
