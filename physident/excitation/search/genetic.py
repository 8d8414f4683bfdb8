"""A genetic algorithm over motions; it finds starting points for a gradient method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.excitation.limits.joint_limits import JointLimits, scale_into_limits
from physident.excitation.motion.series import Series

Array = NDArray[np.float64]
POPULATION = 200
MIN_SIZE = 0.05  # share of the first limit that each joint reaches at least: slow joints keep the tool slow
NODES = 64  # instants at which the joint limits hold


def evolve(
    limits: JointLimits,
    series: Series,
    fitness: Callable[[Array], Array],
    violation: Callable[[Array], Array] | None,
    generations: int,
    seed: int,
    population: int = POPULATION,
    on_generation: Callable[[Array], None] = lambda _: None,
) -> Array:
    """The last population (P, n m), best first, of motions inside the joint limits and at rest at both ends.

    ``fitness`` (P,) of motions (P, n m) is minimised; ``violation`` (P, 1) is zero where all other limits hold. Both are
    called once a generation, and then ``on_generation`` with the best motion (n m,). Source of the operators: Deb and
    Agrawal, "Simulated binary crossover" (1995), as implemented in pymoo.
    """
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    n, m = series.n, series.m

    def motions_of(X: Array) -> Array:
        genes = X.reshape(len(X), n, m + 1)
        return scale_into_limits(limits, series, NODES, genes[:, :, : m - 1], genes[:, :, m - 1], genes[:, :, m])

    class Motions(Problem):
        def _evaluate(self, x: Array, out: dict, *args: object, **kwargs: object) -> None:
            motions = motions_of(x)
            out["F"] = fitness(motions)[:, None]
            if violation is not None:
                out["G"] = violation(motions)

    def best_first(pop: Any) -> Array:
        order = np.lexsort((pop.get("F")[:, 0], pop.get("CV")[:, 0]))
        return motions_of(pop.get("X")[order])

    lower = np.tile([-1.0] * (m - 1) + [MIN_SIZE, 0.0], n)
    constraints = 0 if violation is None else 1
    problem = Motions(n_var=len(lower), n_obj=1, n_ieq_constr=constraints, xl=lower, xu=np.ones(len(lower)))
    result = minimize(
        problem, GA(pop_size=population), ("n_gen", generations), seed=seed, verbose=False,
        callback=lambda algorithm: on_generation(best_first(algorithm.pop)[0]),
    )  # fmt: skip
    return best_first(result.pop)
