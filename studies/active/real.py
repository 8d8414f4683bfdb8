"""Which recordings of a pool to use first: the order that the motions suggest, against every other choice of as many."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.excitation.session.ranking import CRITERIA, rank_recordings
from studies.kept import UR10E_COLUMNS, UR10E_GAINS, need_data

Array = NDArray[np.float64]
PATTERN = "ur-20_02_*.csv"


@dataclass(frozen=True, eq=False)
class Products:
    """For each joint of one run: ``gram`` (n, p, p), ``cross`` (n, p) and ``square`` (n,) of its regressor and torque; ``rows``."""

    gram: Array
    cross: Array
    square: Array
    rows: int

    def __add__(self, other: Products) -> Products:
        return Products(
            self.gram + other.gram, self.cross + other.cross, self.square + other.square, self.rows + other.rows
        )

    def residual(self, theta: Array) -> Array:
        """Squared residual (n,) of parameters."""
        fitted = np.einsum("p,npq,q->n", theta, self.gram, theta)
        return np.maximum(self.square - 2 * self.cross @ theta + fitted, 0.0)


def rank_real_runs() -> dict[str, Any]:
    """Errors on each of eight runs, left out once, after k chosen runs of the other seven and after any k."""
    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    runs = pid.load_recordings(str(data / PATTERN), columns=UR10E_COLUMNS, drive_gains=UR10E_GAINS)
    model = pid.Model.nominal(robot)
    filter = pid.Filter()
    regressors = [pid.build_regressor(robot, model.effects, [pid.prepare(run, filter)], filter) for run in runs]
    products = [products_of(one) for one in regressors]
    base = pid.find_base_parameters(robot, model.effects).independent
    count = len(runs)
    chosen = {name: np.zeros((count, count - 1)) for name in CRITERIA}
    every = [[[] for _ in range(count - 1)] for _ in range(count)]
    for left_out in range(count):
        pool = [i for i in range(count) if i != left_out]
        scale = np.sqrt(np.mean([products[i].square / products[i].rows for i in pool], axis=0))
        for name in CRITERIA:
            order = rank_recordings([regressors[i] for i in pool], 1 / scale, name)
            for k in range(1, count):
                picked = [pool[i] for i in order[:k]]
                chosen[name][left_out, k - 1] = error(products, picked, left_out, base)
        for k in range(1, count):
            every[left_out][k - 1] = [error(products, list(some), left_out, base) for some in combinations(pool, k)]
    random = np.array([[np.mean(errors) for errors in row] for row in every])
    better = {
        name: [
            float(np.mean([np.mean(np.array(every[h][k]) < chosen[name][h, k] - 1e-9) for h in range(count)]))
            for k in range(count - 1)
        ]
        for name in CRITERIA
    }
    best = np.array([[np.min(errors) for errors in row] for row in every])
    return {
        "recordings": [Path(run.source).name for run in runs],
        "k": list(range(1, count)),
        "random": random.mean(axis=0).tolist(),
        "best_of_all": best.mean(axis=0).tolist(),
        **{name: chosen[name].mean(axis=0).tolist() for name in CRITERIA},
        "share_of_random_choices_that_are_better": better,
        "arms_where_chosen_is_worse_than_mean_random": {
            name: (chosen[name] > random + 1e-9).sum(axis=0).tolist() for name in CRITERIA
        },
    }


def products_of(regressor: pid.Regressor) -> Products:
    """The products of a run."""
    n, p = len(regressor.joints), len(regressor.columns)
    gram, cross = np.zeros((n, p, p)), np.zeros((n, p))
    for j, rows in enumerate(regressor.joints):
        gram[j][np.ix_(rows.columns, rows.columns)] = rows.values.T @ rows.values
        cross[j, rows.columns] = rows.values.T @ regressor.torque[:, j]
    return Products(gram, cross, (regressor.torque**2).sum(axis=0), len(regressor.time))


def error(products: list[Products], fitted: list[int], judged: int, base: NDArray[np.intp]) -> float:
    """Relative error [%], a mean over joints, on one run after least squares on others, each joint weighted by its residual."""
    total = products[fitted[0]]
    for i in fitted[1:]:
        total = total + products[i]
    weights = 1 / total.square
    theta = np.zeros(total.gram.shape[1])
    for _ in range(3):
        G = np.tensordot(weights, total.gram, 1)[np.ix_(base, base)]
        b = np.tensordot(weights, total.cross, 1)[base]
        size = np.sqrt(np.maximum(np.diag(G), 1e-300))
        theta = np.zeros(total.gram.shape[1])
        theta[base] = np.linalg.lstsq(G / np.outer(size, size), b / size, rcond=1e-10)[0] / size
        weights = total.rows / np.maximum(total.residual(theta), 1e-300)
    own = products[judged]
    return float(np.mean(100 * np.sqrt(own.residual(theta) / own.square)))


def table_of(found: dict[str, Any]) -> str:
    """The table of the real runs."""
    rows = [
        "UR10e, eight runs, each left out once: relative error [%] on it, mean over joints, after k of the other seven",
        f"{'k':<44}" + "".join(f"{k:9d}" for k in found["k"]),
    ]
    labels = {"prediction": "chosen, smallest variance of prediction", "d_optimal": "chosen, D-optimal"}
    rows += [f"{labels[name]:<44}" + "".join(f"{v:9.2f}" for v in found[name]) for name in CRITERIA]
    rows.append(f"{'mean over all choices of k':<44}" + "".join(f"{v:9.2f}" for v in found["random"]))
    rows.append(f"{'the best choice of k, known afterwards':<44}" + "".join(f"{v:9.2f}" for v in found["best_of_all"]))
    for name in CRITERIA:
        share = found["share_of_random_choices_that_are_better"][name]
        rows.append(f"{f'choices better than {name} [%]':<44}" + "".join(f"{100 * v:9.0f}" for v in share))
    return "\n".join(rows)
