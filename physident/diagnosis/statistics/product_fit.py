"""The joint fit of a model and some effects, from stored products alone."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.baseline_fit import SETTLED, Fit
from physident.diagnosis.problem.candidates import prior_precision
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.normal_equations import pseudo_inverse, whitening
from physident.diagnosis.statistics.stored_products import Key, OptionClass, Products, StoredProducts
from physident.effects.effect import Effect

Array = NDArray[np.float64]
Columns = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Chosen:
    """An effect beside the model, and its columns among the stored ones."""

    key: Key
    effect: Effect
    columns: Columns


@dataclass(frozen=True, kw_only=True, eq=False)
class ProductFit:
    """The columns ``active``, the first ``baseline`` of which are the model's, that are fitted to the ``response`` over some rows,
    with their ``prior`` precision.

    ``memory`` (n,) says how many correlated rows are worth one, ``rows`` (n,) how many there are, ``start`` (n,) [N m|N]
    where the noise is looked for first.
    """

    products: Products
    active: Columns
    baseline: int
    prior: Array
    response: int
    memory: Array
    rows: Array
    start: Array | None = None

    @cached_property
    def fit(self) -> Fit:
        """The fit, its rows weighted as in ``fit_baseline``; residuals row by row are not kept."""
        every = np.append(self.active, self.response)
        each = self.products.each(every, every)
        H, slope, size = each[:, :-1, :-1], each[:, :-1, -1], each[:, -1, -1]
        sigma = np.sqrt(np.maximum(size, 1e-300) / self.rows) if self.start is None else self.start
        while True:
            weights = 1 / (sigma * np.sqrt(self.memory))
            information = np.tensordot(weights**2, H, 1)
            normal = information + np.diag(self.prior)
            inverse = pseudo_inverse(normal)
            x = inverse @ np.tensordot(weights**2, slope, 1)
            left = size - 2 * slope @ x + np.einsum("r,jrs,s->j", x, H, x)
            decided = float(np.sum(inverse * information))
            free = np.maximum(self.rows - decided / len(self.rows), self.rows / 2)
            after = np.sqrt(np.maximum(left, 1e-18 * np.maximum(size, 1e-300)) / free)
            if (after >= SETTLED * sigma).all():
                break
            sigma = np.minimum(after, sigma)
        return Fit(x=x, sigma=after, weights=weights, memory=self.memory, decided=decided, normal=normal, rows=0)

    @property
    def contradicted(self) -> float:
        """By how much the model's parameters contradict what earlier rows said of them: chi squared."""
        return float(self.prior[: self.baseline] @ self.fit.x[: self.baseline] ** 2)

    @cached_property
    def numbers(self) -> Array:
        """How many numbers each active column (k,) chooses: one, or less where a prior holds it."""
        inverse = pseudo_inverse(self.fit.normal)
        return np.sum(inverse * (self.fit.normal - np.diag(self.prior)), axis=1)


def fit_chosen(
    stored: StoredProducts,
    products: Products,
    chosen: Sequence[Chosen],
    whole: Hypothesis,
    start: Array | None = None,
) -> ProductFit:
    """The model of a hypothesis' problem with some effects, fitted to the rows of ``products``."""
    active = np.concatenate([np.arange(stored.baseline), *(c.columns for c in chosen)]).astype(np.intp)
    extra = [prior_precision(c.effect, len(c.columns)) for c in chosen]
    return ProductFit(
        products=products,
        active=active,
        baseline=stored.baseline,
        prior=np.concatenate([whole.problem.freedom.prior, *extra]),
        response=stored.response,
        memory=whole.fit.memory,
        rows=products.worth * whole.fit.memory,
        start=start,
    )


def best_alone(
    stored: StoredProducts, state: ProductFit, count: int, taken: Collection[Key] = (), least: float = 0.0
) -> list[Chosen]:
    """The ``count`` candidates of the most evidence beside a fit on its own rows, each with its best option, best first, without
    those that are ``taken`` and options of which less than the ``least`` share lies outside the fit."""
    fit, products, squares = state.fit, state.products, state.fit.weights**2
    inverse = pseudo_inverse(fit.normal)
    found: list[tuple[float, OptionClass, int]] = []
    worth = products.worth[:, None] * (products.place != products.place.max(axis=1, keepdims=True))
    for group in stored.classes:
        columns, prior = group.columns, group.prior
        flat = columns.ravel()
        BC = products.weighted(squares, state.active, flat)
        Z = (inverse @ BC).reshape(len(inverse), *columns.shape)
        BC = BC.reshape(Z.shape)
        CC = products.own(squares, columns)
        outside = CC - np.moveaxis(Z, 0, 2) @ np.moveaxis(BC, 0, 1)
        y = products.weighted(squares, np.array([state.response]), flat)[0].reshape(columns.shape)
        slope = y - np.tensordot(fit.x, BC, 1)
        root = whitening(CC, outside + prior[:, :, None] * np.eye(columns.shape[1]))
        seen = np.sum(np.einsum("okl,ok->ol", root, slope) ** 2, axis=1)
        held = np.sum(prior[:, :, None] * root**2, axis=(1, 2))
        chosen = columns.shape[1] - held  # numbers: less than one a column where a prior holds it
        size = np.trace(CC, axis1=1, axis2=2)
        rows = np.maximum(worth[:, columns].max(axis=2).sum(axis=0), 1e-300)  # of the joints that an option acts on
        seen = -rows * np.log(np.maximum(1 - seen / rows, 1e-12)) - 2 * chosen
        seen[np.trace(outside, axis1=1, axis2=2) < least * size] = 0.0
        found += [(float(seen[option]), group, option) for option in group.best(seen) if seen[option] > 0]
    free = [one for one in sorted(found, key=lambda one: -one[0]) if one[1].keys[one[2]] not in taken][:count]
    return [Chosen(group.keys[option], group.effects[option], group.columns[option]) for _, group, option in free]
