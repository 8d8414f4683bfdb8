"""A genetic algorithm over motions: it finds the valley, gradients then find its floor."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.excitation.limits.joint_limits import JointLimits, spread
from physident.excitation.motion.series import Series

Array = NDArray[np.float64]
POPULATION = 200
LEAST_SHARE = 0.05  # of the first limit that a joint meets: where tools must be slow, joints must be slower still
NODES = 64  # of the joint limits


def evolve(
    limits: JointLimits,
    series: Series,
    fitness: Callable[[Array], Array],
    violation: Callable[[Array], Array] | None,
    generations: int,
    seed: int,
    population: int = POPULATION,
    passed: Callable[[Array], None] = lambda _: None,
) -> Array:
    """The last population (P, n m), best first, of motions inside the joint limits and at rest at both ends.

    ``fitness`` (P,) of motions (P, n m) is made small; ``violation`` (P, 1) is not positive where other limits hold. One
    call each a generation, after which ``passed`` hears its best motion (n m,). Source of the operators: Deb and
    Agrawal, "Simulated binary crossover" (1995), as pymoo's.
    """
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    n, m = series.n, series.m

    def decoded(X: Array) -> Array:
        genes = X.reshape(len(X), n, m + 1)
        return spread(limits, series, NODES, genes[:, :, : m - 1], genes[:, :, m - 1], genes[:, :, m])

    class Motions(Problem):
        def _evaluate(self, x: Array, out: dict, *args: object, **kwargs: object) -> None:
            motions = decoded(x)
            out["F"] = fitness(motions)[:, None]
            if violation is not None:
                out["G"] = violation(motions)

    def ranked(pop: Any) -> Array:
        order = np.lexsort((pop.get("F")[:, 0], pop.get("CV")[:, 0]))
        return decoded(pop.get("X")[order])

    lower = np.tile([-1.0] * (m - 1) + [LEAST_SHARE, 0.0], n)
    constraints = 0 if violation is None else 1
    problem = Motions(n_var=len(lower), n_obj=1, n_ieq_constr=constraints, xl=lower, xu=np.ones(len(lower)))
    found = minimize(
        problem, GA(pop_size=population), ("n_gen", generations), seed=seed, verbose=False,
        callback=lambda algorithm: passed(ranked(algorithm.pop)[0]),
    )  # fmt: skip
    return ranked(found.pop)
