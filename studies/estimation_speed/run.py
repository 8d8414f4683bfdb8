"""How long does a certified physical estimate take, and what does the plain script for the same problem cost?"""

from __future__ import annotations

import os
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # many small matrices: threads only wait for each other

import cvxpy as cp
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import UR10E_COLUMNS, UR10E_GAINS, keep, need_data

import physident as pid
from physident.dynamics.model import Model
from physident.dynamics.rigid_body_regressor import torque_expression
from physident.effects.catalogue import DEFAULT_EFFECTS, make_effects
from physident.estimation.estimators import Physical
from physident.estimation.least_squares import least_squares
from physident.estimation.physical.cones import physical_cones
from physident.estimation.physical.coordinates import Coordinates
from physident.estimation.physical.prior import Entropic
from physident.estimation.physical.problem import PhysicalProblem
from physident.estimation.physical.semidefinite_program import SemidefiniteProgram
from physident.estimation.regressor_fit import estimate_from
from physident.estimation.weighting import compress
from physident.identifiability.base_parameters import find_base_parameters
from physident.robots.inertia import pseudo_inertia

RUN = "ur-20_02_10-30sec_12harm.csv"
FILTER = pid.Filter(5.0, 100.0)
REFITS = 20
REPEATS = 9
SECONDS = 30.0


def main() -> None:
    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    recording = pid.load_recording(data / RUN, UR10E_COLUMNS, UR10E_GAINS)
    signals = pid.prepare(recording, FILTER)
    moving = signals.moving
    assert moving is not None
    first = int(np.searchsorted(signals.time, moving[0]))
    signals = signals.part(slice(first, first + int(100 * SECONDS)))
    effects = make_effects(DEFAULT_EFFECTS)
    torque_expression(robot)  # the robot's equations of motion are compiled once for each robot
    fresh = _certified(robot, effects, signals)
    again = [_certified(robot, effects, signals) for _ in range(REPEATS)]
    results = {
        "parameters": len(fresh["estimate"].theta), "seconds_of_motion": SECONDS,
        "first_s": fresh["seconds"], "median_s": np.median([a["seconds"] for a in again], axis=0).tolist(),
        "refit_s": _refits(robot, effects, signals), "plain_s": _plain(robot, effects, signals),
        "gap": fresh["estimate"].certificate.gap, "stationarity": fresh["estimate"].certificate.stationarity,
        "violation": fresh["estimate"].certificate.primal,
    }  # fmt: skip
    keep(Path(__file__).parent, results, table(results))


def _certified(robot, effects, signals) -> dict:
    start, processor = time.perf_counter(), time.process_time()
    regressor = pid.build_regressor(robot, effects, [signals], FILTER)
    estimate = estimate_from(robot, effects, regressor, [], Physical(resamples=0), FILTER)
    return {"seconds": [time.perf_counter() - start, time.process_time() - processor], "estimate": estimate}


def _refits(robot, effects, signals) -> list[float]:
    """Median time, and processor time, of a refit with another prior weight and other torques, through the compiled problem."""
    regressor = pid.build_regressor(robot, effects, [signals], FILTER)
    base = find_base_parameters(robot, effects)
    nominal = Model.nominal(robot, effects).theta
    coordinates, cones = Coordinates.around(nominal, base.columns), physical_cones(robot, effects)
    program = SemidefiniteProgram(PhysicalProblem(base.grouping, coordinates, cones, Entropic()))
    sigma = least_squares(regressor, base, nominal, "diagonal").sigma
    rng = np.random.default_rng(0)
    times = []
    for _ in range(REFITS + 1):
        noisy = replace(regressor, torque=regressor.torque + 0.1 * sigma * rng.standard_normal(regressor.torque.shape))
        factor = compress(noisy, base, 1 / sigma)
        start, processor = time.perf_counter(), time.process_time()
        program.solve(factor, 10 ** rng.uniform(-4, -1))
        times.append([time.perf_counter() - start, time.process_time() - processor])
    return [float(t) for t in np.median(times[1:], axis=0)]


def _plain(robot, effects, signals) -> list[float]:
    """The same problem as one would write it down: every row at the recording's rate in one sum of squares."""
    rows = pid.build_regressor(robot, effects, [signals], pid.Filter(25.0, 100.0))  # nothing decimated
    Y, tau = rows.Y.reshape(-1, len(rows.columns)), rows.torque.ravel()
    nominal = Model.nominal(robot, effects).theta
    start, processor = time.perf_counter(), time.process_time()
    theta = cp.Variable(Y.shape[1])
    units = np.stack([pseudo_inertia(unit) for unit in np.eye(10)])
    divergence: Any = 0
    constraints: list[Any] = [theta[60:66] >= 0, theta[66:78] >= 0]
    for i in range(robot.n):
        P: Any = sum(theta[10 * i + k] * units[k] for k in range(10))
        inverse = np.linalg.inv(pseudo_inertia(nominal[10 * i : 10 * i + 10]))
        divergence += cp.trace(inverse @ P) - cp.log_det(P)
        constraints.append(P >> 0)
    problem = cp.Problem(cp.Minimize(cp.sum_squares(Y @ theta - tau) + divergence), constraints)
    try:
        problem.solve(solver=cp.CLARABEL)
    except cp.SolverError as error:
        print(f"the plain script ended with: {error}", file=sys.stderr)
    return [time.perf_counter() - start, time.process_time() - processor]


def table(results: dict) -> str:
    def row(label: str, seconds: list[float]) -> str:
        return f"{label:<48}{1e3 * seconds[0]:9.0f}{1e3 * seconds[1]:12.0f}"

    return "\n".join(
        [
            f"{results['parameters']} parameters, {results['seconds_of_motion']:.0f} s at 100 Hz             ms elapsed   processor",
            row("signals to certified physical estimate, first", results["first_s"]),
            row("signals to certified physical estimate, median", results["median_s"]),
            row("one refit through the compiled problem", results["refit_s"]),
            row("plain script, tall matrix in sum_squares, solve", results["plain_s"]),
            f"proof: violation {results['violation']:.0e}, gradient {results['stationarity']:.0e}, gap {results['gap']:.0e}",
        ]
    )


if __name__ == "__main__":
    main()
