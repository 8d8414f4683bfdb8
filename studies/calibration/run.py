"""Do 95 % intervals cover the truth 95 % of the time when the noise is coloured? 500 simulated identifications."""

from __future__ import annotations

import os
import sys
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # many small matrices: threads only wait for each other

import numpy as np
from scipy.signal import lfilter

from physident.dynamics.model import Model
from physident.dynamics.regressor import build_regressor
from physident.effects.catalogue import DEFAULT_EFFECTS, make_effects
from physident.errors import NotSolvedError, PhysidentWarning
from physident.estimation.estimators import Physical
from physident.estimation.physical.information_shares import BY_DATA
from physident.estimation.regressor_fit import estimate_from
from physident.estimation.weighting import compress
from physident.excitation.motion.trajectory import random_trajectory
from physident.recordings.signals import Filter, Signals
from physident.robots.inertia import link_parameters, pseudo_inertia
from physident.robots.load import load_robot

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import keep

from physident.graphics.style import JOINTS, figure, save

RUNS = 500
WORKERS = 2
DURATION, RATE = 40.0, 100.0  # s, Hz
NOISE = np.array([2.0, 3.0, 1.5, 0.4, 0.5, 0.5])  # N m
MEMORY = 0.3  # s: the slow part of the noise forgets over this time
WHITE = 0.5  # white part of the noise over the slow part
SPREAD = 0.3  # logarithmic, of the true links' pseudo-inertia around the nominal one
ROTOR = np.array([1.2, 1.2, 0.9, 0.21, 0.21, 0.21])  # kg m^2
VISCOUS = np.array([9.0, 9.0, 6.0, 2.5, 2.0, 1.5])  # N m s/rad
COULOMB = np.array([7.7, 8.3, 7.8, 1.4, 2.0, 2.1])  # N m
OFFSET = np.array([0.5, -0.5, 0.2, 0.1, 0.0, -0.1])  # N m
METHODS = {"wls": "wls", "robust": "robust", "physical": Physical(resamples=40)}


def hidden_model(seed: int = 0) -> Model:
    """A UR5 whose links differ from their description in every direction, with friction, rotors and offsets."""
    rng = np.random.default_rng(seed)
    nominal = Model.nominal(load_robot("ur5"))
    theta = nominal.theta.copy()
    for i in range(0, 60, 10):
        values, vectors = np.linalg.eigh(pseudo_inertia(theta[i : i + 10]))
        root = (vectors * np.sqrt(values)) @ vectors.T
        A = rng.standard_normal((4, 4))
        turn, directions = np.linalg.eigh((A + A.T) / 2)
        theta[i : i + 10] = link_parameters(root @ (directions * np.exp(SPREAD * turn)) @ directions.T @ root)
    theta[60:] = np.concatenate([ROTOR, VISCOUS, COULOMB, OFFSET])
    return Model(nominal.robot, nominal.effects, theta)


def coloured(shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Noise (N, n) [N m]: a slow part that forgets exponentially, and a white part."""
    keep = np.exp(-1 / (RATE * MEMORY))
    drive = rng.standard_normal((shape[0] + 1000, shape[1]))
    slow = lfilter([np.sqrt(1 - keep**2)], [1, -keep], drive, axis=0)[1000:]
    return NOISE * (slow + WHITE * rng.standard_normal(shape))


def textbook_errors(regressor, base, sigma) -> np.ndarray:
    """Standard errors (r,) as for independent residuals: the inverse normal matrix of the weighted rows."""
    R = compress(regressor, base, 1 / sigma).R
    return np.linalg.norm(np.linalg.inv(R), axis=1)


def main(runs: int = RUNS) -> dict[str, Any]:
    started = time.time()
    with ProcessPoolExecutor(WORKERS) as pool:
        outcomes = list(pool.map(one_run, range(runs), chunksize=5))
    solved = [o for o in outcomes if o is not None]
    hits = {name: np.array([o["hits"][name] for o in solved]) for name in (*METHODS, "textbook")}
    decided = np.array([o["decided"] for o in solved])
    return {
        "runs": runs, "refused": runs - len(solved), "base_parameters": decided.shape[1], "rows": solved[0]["rows"],
        "effective_samples": np.mean([o["effective"] for o in solved], axis=0).tolist(),
        "coverage": {
            name: _coverage(h, decided if name == "physical" else np.ones_like(h)) for name, h in hits.items()
        },
        "seconds": time.time() - started,
    }  # fmt: skip


def one_run(seed: int) -> dict[str, Any] | None:
    """Which intervals of one identification hold the truth; None where an estimator refused its data."""
    warnings.simplefilter("ignore", PhysidentWarning)
    truth, filter = hidden_model(), Filter(5.0)
    robot, effects = truth.robot, make_effects(DEFAULT_EFFECTS)
    t, q, v, a = random_trajectory(robot, seed=seed, duration=DURATION).sample(RATE)
    clean = Signals(t, q, v, a, rate=RATE)
    torque = truth.torque(clean) + coloured(q.shape, np.random.default_rng(10_000 + seed))
    regressor = build_regressor(robot, effects, [replace(clean, torque=torque)], filter)
    try:
        found = {name: estimate_from(robot, effects, regressor, [], m, filter) for name, m in METHODS.items()}
    except NotSolvedError as error:
        print(f"run {seed}: {error}", file=sys.stderr)
        return None
    base = found["wls"].base
    target = base.values(truth.theta)
    hits = {name: (e.intervals()[:, 0] <= target) & (target <= e.intervals()[:, 1]) for name, e in found.items()}
    half = 1.96 * textbook_errors(regressor, base, found["wls"].sigma)
    hits["textbook"] = np.abs(base.values(found["wls"].theta) - target) <= half
    return {
        "hits": hits, "decided": np.array(found["physical"].base_shares) >= BY_DATA,
        "effective": found["wls"].effective_samples, "rows": len(regressor.torque),
    }  # fmt: skip


def _coverage(hits: np.ndarray, counted: np.ndarray) -> dict[str, Any]:
    """Coverage [%] over all counted cases, and its range over the parameters counted in at least half of the runs."""
    often = counted.mean(axis=0) >= 0.5
    each = 100 * (hits & counted)[:, often].sum(axis=0) / counted[:, often].sum(axis=0)
    return {
        "mean_percent": 100 * float(hits[counted].mean()), "lowest_percent": float(each.min()),
        "highest_percent": float(each.max()), "parameters": int(often.sum()),
        "within_92_98": int(((each >= 92) & (each <= 98)).sum()), "each_percent": each.tolist(),
    }  # fmt: skip


def table(results: dict[str, Any]) -> str:
    worth = " ".join(f"{x:.0f}" for x in results["effective_samples"])
    rows = [
        f"{results['runs']} identifications of {results['base_parameters']} base parameters;"
        f" {results['rows']} rows worth {worth} per joint; {results['refused']} refused",
        "errors               coverage %   lowest  highest  parameters  within 92-98 %",
    ]
    names = {
        "wls": "wls, block jackknife",
        "robust": "robust",
        "physical": "physical, bootstrap",
        "textbook": "wls, textbook",
    }
    for name, c in results["coverage"].items():
        rows.append(
            f"{names[name]:<20} {c['mean_percent']:10.1f} {c['lowest_percent']:8.1f} {c['highest_percent']:8.1f}"
            f" {c['parameters']:11d} {c['within_92_98']:11d}"
        )
    return "\n".join(rows)


def plot(results: dict[str, Any], path: Path) -> None:
    """Coverage of every parameter, sorted, for each kind of error."""
    fig, axes = figure(1, 1, (7.0, 3.0))
    axis = axes[0, 0]
    axis.axhspan(92, 98, color="0.9")
    for color, (name, c) in zip(JOINTS, results["coverage"].items(), strict=False):
        each = np.sort(c["each_percent"])
        axis.plot(np.linspace(0, 100, len(each)), each, "o-", ms=3, color=color, label=name)
    axis.set(xlabel="share of the base parameters [%]", ylabel="covered by 95 % intervals [%]", ylim=(0, 101))
    axis.legend(loc="lower right")
    save(fig, path)


if __name__ == "__main__":
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else RUNS
    results = main(runs)
    if runs == RUNS:
        plot(results, Path(__file__).with_name("coverage.png"))
        keep(Path(__file__).parent, results, table(results))
    else:
        print(table(results))
