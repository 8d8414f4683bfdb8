# fast: real recordings and simulations, one to two minutes
"""OLS, WLS, robust and physical side by side: unseen error, violated physics, parameter error, time."""

from __future__ import annotations

import os
import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # many small matrices: threads only wait for each other

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import UR5_GAINS, UR10E_COLUMNS, UR10E_GAINS, joint_row, keep, need_data

import physident as pid
from physident.dynamics.model import Model
from physident.errors import NotSolvedError, PhysidentWarning
from physident.estimation.estimators import OLS, WLS, Estimator, Physical, Robust
from physident.estimation.physical.prior import NoPrior
from physident.estimation.regressor_fit import estimate_from
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.signals import Signals
from physident.robots.inertia import link_parameters, pseudo_inertia

METHODS: dict[str, Estimator] = {
    "ols": OLS(),
    "wls": WLS(),
    "robust": Robust(),
    "physical": Physical(resamples=0),
    "physical, huber": Physical(loss="huber", resamples=0),
    "physical, no prior": Physical(NoPrior(), resamples=0),
}
NOISE = np.array([2.0, 3.0, 1.5, 0.4, 0.5, 0.5])  # N m, white at 100 Hz
OUTLIERS = 30.0  # times the noise, in bursts of 0.2 s that take one second in thirty
SEEDS = 8
FRICTION = np.array([1.2, 1.2, 0.9, 0.2, 0.2, 0.2, 9, 9, 6, 2.5, 2, 1.5, 7.7, 8.3, 7.8, 1.4, 2, 2.1, 0, 0, 0, 0, 0, 0])
FILTER = pid.Filter(5.0)


def main() -> None:
    warnings.simplefilter("ignore", PhysidentWarning)
    results = {"ur10e": ur10e(), "ur5": ur5(), "simulated": simulated(), "round_trip": round_trip()}
    keep(Path(__file__).parent, results, table(results))


def ur10e() -> dict[str, Any]:
    """Each of eight runs left out once."""
    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    runs = pid.load_recordings(str(data / "ur-20_02_*.csv"), columns=UR10E_COLUMNS, drive_gains=UR10E_GAINS)
    results = {}
    for name, method in METHODS.items():
        errors, broken, seconds, rotor, mass = [], [], [], [], []
        for left_out in range(len(runs)):
            train = [run for i, run in enumerate(runs) if i != left_out]
            estimate, took = timed(robot, train, method, pid.Filter(5.0, 100.0))
            errors.append(pid.validate(estimate, [runs[left_out]]).relative_all)
            broken.append(len(estimate.violations))
            seconds.append(took)
            rotor.append(float(estimate.model.parameters("rotor_inertia").min()))
            mass.append([float(f(estimate.theta[:60:10])) for f in (np.min, np.max)])
        results[name] = {
            "relative_percent": np.mean(errors, axis=0).tolist(), "violations": float(np.mean(broken)),
            "seconds": float(np.median(seconds)), "smallest_rotor_inertia": min(rotor),
            "link_mass_range": [min(m[0] for m in mass), max(m[1] for m in mass)],
        }  # fmt: skip
    return results


def ur5() -> dict[str, Any]:
    """Fitted on three movements, judged on a fourth."""
    data = need_data("ur5")
    robot = pid.load_robot("ur5")
    train = pid.load_recordings([data / f"{k}.csv.gz" for k in ("move6", "move5", "move9")], drive_gains=UR5_GAINS)
    unseen = pid.load_recordings(data / "move8.csv.gz", drive_gains=UR5_GAINS)
    results = {}
    for name, method in METHODS.items():
        estimate, took = timed(robot, train, method, pid.Filter(8.0))
        results[name] = {
            "relative_percent": pid.validate(estimate, unseen).relative_all.tolist(),
            "violations": len(estimate.violations), "seconds": took,
            "smallest_rotor_inertia": float(estimate.model.parameters("rotor_inertia").min()),
        }  # fmt: skip
    return results


def simulated() -> dict[str, Any]:
    """A UR5 whose links differ from their description: short and long data, with and without outliers."""
    truth = hidden_model(0)
    base = find_base_parameters(truth.robot, truth.effects)
    target = base.values(truth.theta)
    unseen = _regress(truth, 900, 20.0, 0.0, False)
    size = np.linalg.norm(unseen.torque, axis=0)
    results: dict[str, Any] = {}
    for duration, outliers in ((2.0, False), (2.0, True), (20.0, False), (20.0, True)):
        case = results[f"{duration:g} s{', outliers' if outliers else ''}"] = {}
        for name, method in METHODS.items():
            errors, parameters, broken, failed = [], [], [], 0
            for seed in range(SEEDS):
                regressor = _regress(truth, seed, duration, 1.0, outliers)
                try:
                    estimate = estimate_from(truth.robot, truth.effects, regressor, [], method, FILTER)
                except NotSolvedError:
                    failed += 1
                    continue
                wrong = np.linalg.norm(unseen.predict(estimate.theta - truth.theta), axis=0)
                errors.append(100 * np.mean(wrong / size))
                parameters.append(np.linalg.norm(base.values(estimate.theta) - target) / np.linalg.norm(target))
                broken.append(len(estimate.violations))
            case[name] = {
                "unseen_percent": float(np.median(errors)) if errors else None,
                "base_parameter_percent": 100 * float(np.median(parameters)) if errors else None,
                "violations": float(np.mean(broken)) if errors else None, "refused": failed,
            }  # fmt: skip
    return results


def round_trip() -> dict[str, Any]:
    """Recordings simulated from the model of a real UR10e, identified again: how many intervals hold its values?"""
    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    runs = pid.load_recordings(str(data / "ur-20_02_*.csv"), columns=UR10E_COLUMNS, drive_gains=UR10E_GAINS)
    filter = pid.Filter(5.0, 100.0)
    motions = [pid.prepare(run, filter) for run in runs]
    results = {}
    for name, method in {"wls": WLS(), "robust": Robust(), "physical": Physical(resamples=100)}.items():
        first = pid.identify(robot, runs, method=method, filter=filter)
        rng = np.random.default_rng(1)
        torques = [first.model.torque(m) + _slow(m.q.shape, rng) * first.sigma for m in motions]
        signals = [replace(m, torque=tau) for m, tau in zip(motions, torques, strict=True)]
        regressor = pid.build_regressor(robot, first.model.effects, signals, filter)
        again = estimate_from(robot, first.model.effects, regressor, [], method, filter)
        ends, target = again.intervals(), first.base.values(first.theta)
        inside = (ends[:, 0] <= target) & (target <= ends[:, 1])
        decided = np.array(again.base_shares) >= 0.9
        results[name] = {"inside": int(inside[decided].sum()), "of": int(decided.sum()), "base_parameters": len(inside)}
    return results


def timed(robot: pid.Robot, train: list[pid.Recording], method: Estimator, filter: pid.Filter) -> tuple[Any, float]:
    start = time.process_time()
    estimate = pid.identify(robot, train, method=method, filter=filter)
    return estimate, time.process_time() - start


def hidden_model(seed: int) -> Model:
    """A UR5 whose links differ from their description by 30 % in the logarithm, in every direction."""
    rng = np.random.default_rng(seed)
    nominal = Model.nominal(pid.load_robot("ur5"))
    theta = nominal.theta.copy()
    for i in range(0, 60, 10):
        values, vectors = np.linalg.eigh(pseudo_inertia(theta[i : i + 10]))
        root = (vectors * np.sqrt(values)) @ vectors.T
        A = rng.standard_normal((4, 4))
        turn, directions = np.linalg.eigh((A + A.T) / 2)
        theta[i : i + 10] = link_parameters(root @ (directions * np.exp(0.3 * turn)) @ directions.T @ root)
    theta[60:] = FRICTION
    return Model(nominal.robot, nominal.effects, theta)


def _regress(truth: Model, seed: int, duration: float, noise: float, outliers: bool) -> Any:
    """``duration`` seconds from the middle of a motion, after the filter has taken its own second."""
    t, q, v, a = pid.random_trajectory(truth.robot, seed=seed, duration=30.0).sample(100.0)
    part = slice(300, 300 + int(100 * (duration + 1.0)))
    motion = Signals(t[part], q[part], v[part], a[part], rate=100.0)
    rng = np.random.default_rng(seed)
    error = noise * NOISE * rng.standard_normal(motion.q.shape)
    if outliers:
        bursts = (rng.random((-(-len(motion.q) // 20), 6)) < 1 / 30).repeat(20, axis=0)[: len(motion.q)]
        error = error + OUTLIERS * noise * NOISE * bursts
    return pid.build_regressor(
        truth.robot, truth.effects, [replace(motion, torque=truth.torque(motion) + error)], FILTER
    )


def _slow(shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Noise (N, n) of unit variance that forgets over 0.3 s at 100 Hz, as a real arm's residuals do."""
    from scipy.signal import lfilter

    keep = np.exp(-1 / 30)
    drive = rng.standard_normal((shape[0] + 500, shape[1]))
    return np.asarray(lfilter([np.sqrt(1 - keep**2)], [1, -keep], drive, axis=0))[500:]


def table(results: dict[str, Any]) -> str:
    rows = [
        "real UR10e, each of 8 runs left out once: unseen error %, violated cones, least rotor inertia, link masses, processor s"
    ]
    for name, r in results["ur10e"].items():
        low, high = r["link_mass_range"]
        rows.append(
            joint_row(name, r["relative_percent"])
            + f"  {r['violations']:4.1f} {r['smallest_rotor_inertia']:8.2f} kg m^2 {low:7.2f}..{high:.2f} kg {r['seconds']:6.2f}"
        )
    rows += [
        "",
        "real UR5, fitted on move6+5+9, judged on move8: unseen error %, violated cones, least rotor inertia, processor s",
    ]
    for name, r in results["ur5"].items():
        rows.append(
            joint_row(name, r["relative_percent"])
            + f"  {r['violations']:4.1f} {r['smallest_rotor_inertia']:8.2f} kg m^2 {r['seconds']:6.2f}"
        )
    rows += [
        "",
        f"simulated UR5, median of {SEEDS}: unseen error % / base parameter error % / violated cones (refused fits)",
    ]
    cases = results["simulated"]
    rows.append(" " * 20 + "".join(f"{case:>28}" for case in cases))
    for name in METHODS:
        rows.append(f"{name:<20}" + "".join(f"{_cell(cases[case][name]):>28}" for case in cases))
    rows += ["", "round trip: values of the real UR10e's model inside the 95 % intervals of its simulated recordings"]
    rows += [f"{name:<20}{r['inside']} of {r['of']} that the data decided" for name, r in results["round_trip"].items()]
    return "\n".join(rows)


def _cell(r: dict[str, Any]) -> str:
    refused = f" ({r['refused']})" if r["refused"] else ""
    if r["unseen_percent"] is None:
        return "-" + refused
    return f"{r['unseen_percent']:.1f} / {r['base_parameter_percent']:.1f} / {r['violations']:.1f}{refused}"


if __name__ == "__main__":
    main()
