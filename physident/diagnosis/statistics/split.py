"""One fold that is left out: what the other folds decide about every candidate, and what that gains inside the fold."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidate_groups import OptionGroup
from physident.diagnosis.statistics.normal_equations import pseudo_inverse, whitening

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WeightedProducts:
    """Products over some rows in units of the noise: baseline BB (R, R), with candidates BC (R, P), and those of each option's own
    columns, a (O, k, k) for each class."""

    BB: Array
    BC: Array
    CC: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class WeightedResponses:
    """Products of responses over some rows in units of the noise: with the baseline By (R, S), with candidates Cy (P, S), and with
    themselves yy (S,)."""

    By: Array
    Cy: Array
    yy: Array


@dataclass(frozen=True, eq=False)
class Class:
    """The options of one number of columns, ``group``; their ``columns`` (O, k) among the P, and for each of its candidates
    ``owners`` (C,) the ``options`` (C, most), filled up with the first."""

    group: OptionGroup
    columns: NDArray[np.intp]

    @cached_property
    def owners(self) -> NDArray[np.intp]:
        """The candidates (C,) of the options."""
        return np.unique(self.group.owner)

    @cached_property
    def options(self) -> NDArray[np.intp]:
        """The options (C, most) of each candidate, filled up with the first."""
        each = [np.flatnonzero(self.group.owner == owner) for owner in self.owners]
        most = max(map(len, each))
        return np.array([np.append(mine, np.full(most - len(mine), mine[0])) for mine in each])

    @property
    def single(self) -> bool:
        """Whether each candidate has one option."""
        return self.options.shape[1] == 1


@dataclass(frozen=True, eq=False)
class Values:
    """What responses S give to one class: the values of ``every`` option (O, k, S), the option of each candidate with the largest gain,
    ``tops`` (C, S), and its values ``theta`` (C, k, S)."""

    every: Array
    tops: NDArray[np.intp]
    theta: Array


class Split:
    """What does not depend on the response: the baseline and each option fitted outside a fold, and what they do inside."""

    def __init__(
        self, classes: Sequence[Class], train: WeightedProducts, test: Sequence[WeightedProducts], prior: Array
    ) -> None:
        self.classes, self.train, self.test, self.prior = classes, train, test, prior
        self.kept: dict[tuple[int, int | None], Array] = {}
        self.inverse = pseudo_inverse(train.BB + np.diag(prior))
        self.Z = self.inverse @ train.BC
        self.roots = []
        for one, inner in zip(classes, train.CC, strict=True):
            Zc = self._Zc(one, slice(None))
            cross = Zc @ np.moveaxis(train.BC[:, one.columns], 0, 1)
            self.roots.append(whitening(inner, inner - cross + one.group.prior_normal))

    def judge(
        self, train: WeightedResponses, test: Sequence[WeightedResponses], count: int
    ) -> tuple[Array, Array, Array]:
        """Costs (n, S) of the baseline on the fold by joint, gains (count, n, S) of the candidates there, and by how much (count, S)
        their baseline contradicts its prior less."""
        x = self.inverse @ train.By
        slope = train.Cy - self.train.BC.T @ x
        n, S = len(test), x.shape[1]
        before, left = np.empty((n, S)), []
        for j, (part, own) in enumerate(zip(test, self.test, strict=True)):
            predicted = own.BB @ x
            left.append((part.Cy, part.By - predicted, own.BC))
            before[j] = part.yy - 2 * np.sum(x * part.By, axis=0) + np.sum(x * predicted, axis=0)
        gain, relief = np.zeros((count, n, S)), np.zeros((count, S))
        chosen = [self._chosen(k, slope) for k in range(len(self.classes))]
        contradicted = self.prior[:, None] * x
        for k, (one, values) in enumerate(zip(self.classes, chosen, strict=True)):
            if self.prior.any():
                relief[one.owners] = self._relief(k, values, contradicted)
        for j, (Cy, By, BC) in enumerate(left):
            moved = Cy - BC.T @ x - self.Z.T @ By
            for k, (one, values) in enumerate(zip(self.classes, chosen, strict=True)):
                pulled = _at(moved, one.columns, values.tops)
                gain[one.owners, j] = 2 * np.sum(values.theta * pulled, axis=1) - self._spread(k, j, values)
        return before, gain, relief

    def _chosen(self, k: int, slope: Array) -> Values:
        """The option of the largest gain outside the fold, and its values."""
        one, root = self.classes[k], self.roots[k]
        pull = slope[one.columns]
        theta = root @ (root.transpose(0, 2, 1) @ pull)
        if one.single:
            order = one.options[:, 0]
            return Values(theta, np.repeat(order[:, None], slope.shape[1], axis=1), theta[order])
        seen = np.sum(theta * pull, axis=1)
        best = np.argmax(seen[one.options], axis=1)
        tops = np.take_along_axis(one.options, best, axis=1)
        return Values(theta, tops, theta[tops, :, np.arange(slope.shape[1])].transpose(0, 2, 1))

    def _spread(self, k: int, j: int, values: Values) -> Array:
        """The power (C, S) of the chosen options in a joint's rows of the fold, the baseline refitted."""
        return self._quadratic(values, (k, j), lambda some: self._apart(k, j, some))

    def _apart(self, k: int, j: int, some: NDArray[np.intp]) -> Array:
        one, own = self.classes[k], self.test[j]
        c = one.columns[some]
        Z = self.Z[:, c.ravel()]
        pulled = (0.5 * (own.BB @ Z) - own.BC[:, c.ravel()]).reshape(len(Z), *c.shape)  # one product of large matrices
        half = Z.reshape(pulled.shape).transpose(1, 2, 0) @ pulled.transpose(1, 0, 2)
        return own.CC[k][some] + half + half.transpose(0, 2, 1)

    def _relief(self, k: int, values: Values, contradicted: Array) -> Array:
        one = self.classes[k]

        def held(some: NDArray[np.intp]) -> Array:
            Zc = self._Zc(one, some)
            return Zc @ (self.prior[:, None] * Zc.transpose(0, 2, 1))

        pulled = _at(self.Z.T @ contradicted, one.columns, values.tops)
        return 2 * np.sum(values.theta * pulled, axis=1) - self._quadratic(values, (k, None), held)

    def _quadratic(
        self, values: Values, key: tuple[int, int | None], matrices: Callable[[NDArray[np.intp]], Array]
    ) -> Array:
        """theta^T A theta (C, S) of the chosen options, whose matrices A (o, k, k) are computed for some of them; kept by a ``key`` for
        all, where many responses ask for nearly all, again and again."""
        if values.tops.shape[1] == 1:
            return np.sum(values.theta * (matrices(values.tops[:, 0]) @ values.theta), axis=1)
        if key not in self.kept:
            self.kept[key] = matrices(np.arange(len(values.every)))
        power = np.sum(values.every * (self.kept[key] @ values.every), axis=1)
        return np.take_along_axis(power, values.tops, axis=0)

    def _Zc(self, one: Class, some: NDArray[np.intp] | slice) -> Array:
        return np.moveaxis(self.Z[:, one.columns[some]], 0, 2)  # (O, k, R)


def _at(values: Array, columns: NDArray[np.intp], tops: NDArray[np.intp]) -> Array:
    """Values (P, S) at the columns of the chosen options: (C, k, S)."""
    return values[columns[tops].transpose(0, 2, 1), np.arange(values.shape[1])]
