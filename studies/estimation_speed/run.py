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
from physident.base_parameters import find_base_parameters
from physident.effects.catalogue import DEFAULT_EFFECTS, make_effects
from physident.estimation.cones import physical_cones
from physident.estimation.coordinates import Coordinates
from physident.estimation.estimators import Physical
from physident.estimation.identify import estimate_from
from physident.estimation.least_squares import least_squares
from physident.estimation.physical import Program
from physident.estimation.prior import Entropic
from physident.estimation.weighting import compress
from physident.inertia import pseudo_inertia
from physident.model import Model
from physident.rigid_body_regressor import torque_expression

RUN = "ur-20_02_10-30sec_12harm.csv"
FILTER = pid.Filter(5.0, 100.0)
REFITS = 20


def main() -> None:
    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    recording = pid.load_recording(data / RUN, UR10E_COLUMNS, UR10E_GAINS)
    signals = pid.prepare(recording, FILTER)
    effects = make_effects(DEFAULT_EFFECTS)
    torque_expression(robot)  # the robot's equations of motion are compiled once for each robot
    first = _certified(robot, effects, signals)
    again = [_certified(robot, effects, signals)["seconds"] for _ in range(5)]
    results = {
        "parameters": len(first["estimate"].theta), "seconds_of_motion": first["estimate"].sources and None,
        "first_s": first["seconds"], "median_s": float(np.median(again)),
        "refit_s": _refits(robot, effects, signals), "plain_s": _plain(robot, effects, signals),
        "gap": first["estimate"].certificate.gap, "stationarity": first["estimate"].certificate.stationarity,
        "violation": first["estimate"].certificate.primal,
    }  # fmt: skip
    results["seconds_of_motion"] = recording.duration
    keep(Path(__file__).parent, results, table(results))


def _certified(robot, effects, signals) -> dict:
    start = time.perf_counter()
    regressor = pid.build_regressor(robot, effects, [signals], FILTER)
    estimate = estimate_from(robot, effects, regressor, [], Physical(resamples=0), FILTER)
    return {"seconds": time.perf_counter() - start, "estimate": estimate}


def _refits(robot, effects, signals) -> float:
    """Median time of a refit with another prior weight and other torques, through the compiled problem."""
    regressor = pid.build_regressor(robot, effects, [signals], FILTER)
    base = find_base_parameters(robot, effects)
    nominal = Model.nominal(robot, effects).theta
    program = Program(
        base.grouping, Coordinates.around(nominal, base.columns), physical_cones(robot, effects), Entropic()
    )
    sigma = least_squares(regressor, base, nominal, "diagonal").sigma
    rng = np.random.default_rng(0)
    times = []
    for _ in range(REFITS + 1):
        noisy = replace(regressor, torque=regressor.torque + 0.1 * sigma * rng.standard_normal(regressor.torque.shape))
        factor = compress(noisy, base, 1 / sigma)
        start = time.perf_counter()
        program.solve(factor, 10 ** rng.uniform(-4, -1))
        times.append(time.perf_counter() - start)
    return float(np.median(times[1:]))


def _plain(robot, effects, signals) -> float:
    """The same problem as one would write it down: every row at the recording's rate in one sum of squares."""
    rows = pid.build_regressor(robot, effects, [signals], pid.Filter(25.0, 100.0))  # nothing decimated
    Y, tau = rows.Y.reshape(-1, len(rows.columns)), rows.torque.ravel()
    nominal = Model.nominal(robot, effects).theta
    start = time.perf_counter()
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
    return time.perf_counter() - start


def table(results: dict) -> str:
    return "\n".join(
        [
            f"{results['parameters']} parameters, {results['seconds_of_motion']:.0f} s of motion at 100 Hz",
            f"signals to certified physical estimate, first  {1e3 * results['first_s']:8.0f} ms",
            f"signals to certified physical estimate, median {1e3 * results['median_s']:8.0f} ms",
            f"one refit through the compiled problem         {1e3 * results['refit_s']:8.0f} ms",
            f"plain script, tall matrix in sum_squares       {1e3 * results['plain_s']:8.0f} ms (solve alone)",
            f"proof: violation {results['violation']:.0e}, gradient {results['stationarity']:.0e}, gap {results['gap']:.0e}",
        ]
    )


if __name__ == "__main__":
    main()
