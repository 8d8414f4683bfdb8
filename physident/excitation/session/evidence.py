"""What motions would show of open questions: information matrices, noncentralities and powers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import f, ncf, norm

from physident.dynamics.model import Model
from physident.dynamics.regressor import build_regressor
from physident.effects.effect import Effect
from physident.excitation.detectability import EVIDENCE, RATE, TEMPERATURE, Noise
from physident.excitation.motion.motion import Motion
from physident.excitation.session.questions import VAGUE, OpenQuestion
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
ENOUGH = 0.9  # power: a question is then as good as settled, and minutes go to others
SMALLEST_POWER = 0.8  # at which the smallest size is stated that would be found
RIDGE = 1e-7  # of a unit column: a smaller part outside the other columns counts as zero
SMALL, LARGE = 1e-6, 1e3  # noncentralities beyond which the power is that of chance, or one to rounding
HALF = 1.96  # standard errors in half of a 95 % interval


@dataclass(frozen=True, eq=False)
class Shown:
    """What motions show together: ``gram`` (p, p) of all columns in units of the noise, and ``samples`` (n,) independent ones."""

    gram: Array
    samples: Array

    def __add__(self, other: Shown) -> Shown:
        return Shown(self.gram + other.gram, self.samples + other.samples)


@dataclass(frozen=True, eq=False)
class _Places:
    """Indices of a question's columns, of those that are refitted beside it, of its rivals' variants, and the joints (from 0)."""

    own: NDArray[np.intp]
    beside: NDArray[np.intp]
    rivals: tuple[NDArray[np.intp], ...]
    joints: NDArray[np.intp]


class Evidence:
    """What motions of an arm would show of ``questions``; ``heavy`` is the model with a known load, for loaded motions."""

    def __init__(self, model: Model, heavy: Model | None, noise: Noise, questions: Sequence[OpenQuestion]) -> None:
        self.model, self.heavy, self.noise, self.questions = model, heavy or model, noise, tuple(questions)
        base = find_base_parameters(model.robot, model.effects).independent
        extra: list[Effect] = []
        self.places = [self._placed(one, base, extra) for one in self.questions]
        self.effects = (*model.effects, *extra)
        self.sizes: list[Array] = [np.array(one.sizes) for one in self.questions]

    def shown(self, motion: Motion, loaded: bool = False) -> Shown:
        """What a recording of a motion would show."""
        model, noise, n = self.heavy if loaded else self.model, self.noise, self.model.robot.n
        time, q, v, a = motion.sample(RATE)
        plan = Signals(
            time, q, v, a, None, np.full_like(q, TEMPERATURE), rate=RATE, cutoff=noise.filter.cutoff, source="a planned motion"
        )  # fmt: skip
        signals = replace(model.refer(plan), torque=np.zeros_like(q))
        return self.of_signals(signals, model, n)

    def of_signals(self, signals: Signals, model: Model, n: int) -> Shown:
        """What signals of a motion show."""
        noise = self.noise
        regressor = build_regressor(model.robot, self.effects, [signals], noise.filter, model=model)
        memory = np.maximum(regressor.kept_rate / noise.worth, 1.0)
        weights = 1 / (noise.sigma * np.sqrt(memory))
        p = len(regressor.columns)
        gram = np.zeros((p, p))
        for j, rows in enumerate(regressor.joints):
            values = rows.values * weights[j]
            gram[np.ix_(rows.columns, rows.columns)] += values.T @ values
        return Shown(gram, len(regressor.time) / memory)

    def sized_by(self, reference: Shown) -> None:
        """Let every effect of unknown size be as large as the noise along ``reference``."""
        energy = np.diag(reference.gram)
        for k, place in enumerate(self.places):
            if not self.questions[k].sizes:
                worth = float(np.mean(reference.samples[place.joints]))
                self.sizes[k] = np.sqrt(worth / np.maximum(energy[place.own], 1e-300)) * (energy[place.own] > 0)

    def noncentralities(self, shown: Shown) -> Array:
        """Noncentrality (K,) of each question's effect beside what is refitted and its most similar rival.

        For a value it is its square over its variance, with what is known of it now.
        """
        return np.array([self._noncentrality(k, shown) for k in range(len(self.questions))])

    def needed(self, samples: Array) -> Array:
        """The noncentrality (K,) with which each question is as good as settled, for ``samples`` (n,) independent samples."""
        return np.array([self._at_power(k, samples, ENOUGH) for k in range(len(self.questions))])

    def powers(self, shown: Shown) -> Array:
        """Power (K,) to settle each question: a noncentral F of the evidence beyond what a diagnosis requires, or the chance that
        the interval of a value is narrow enough."""
        found = self.noncentralities(shown)
        return np.array([self._power(k, found[k], shown.samples) for k in range(len(found))])

    def smallest(self, shown: Shown) -> Array:
        """The share (K,) of each assumed size that is found with a power of 80 %; infinite for never."""
        found = self.noncentralities(shown)
        needed = [self._at_power(k, shown.samples, SMALLEST_POWER) for k in range(len(found))]
        return np.sqrt(np.divide(needed, found, out=np.full(len(found), np.inf), where=found > 0))

    def _placed(self, question: OpenQuestion, base: NDArray[np.intp], extra: list[Effect]) -> _Places:
        """Where a question's columns are; new effects join ``extra``."""
        robot, model = self.model.robot, self.model
        own = self._columns_of(question.effect, extra)
        rivals = tuple(self._columns_of(one, extra) for one in question.rivals)
        fixed = question.model_fixed
        beside = np.array([] if fixed else [c for c in base if c not in set(own.tolist())], dtype=np.intp)
        joints = sorted({c.joint - 1 for c in question.effect.columns(robot)})
        everywhere = question.effect.joints is None or question.model_fixed
        return _Places(own, beside, rivals, np.arange(model.robot.n) if everywhere else np.array(joints))

    def _columns_of(self, effect: Effect, extra: list[Effect]) -> NDArray[np.intp]:
        """The columns of an effect: those of the model, where it has the effect in the same shape, or new ones."""
        robot, start = self.model.robot, 0
        names = [c.name for c in effect.columns(robot)]
        for known in (*self.model.effects, *extra):
            columns = known.columns(robot)
            mine = {c.name: start + k for k, c in enumerate(columns)}
            start += len(columns)
            if known.name == effect.name and set(names) <= set(mine) and _same_shape(known, effect):
                return np.array([mine[name] for name in names], dtype=np.intp)
        extra.append(effect)
        return np.arange(start, start + len(names), dtype=np.intp)

    def _noncentrality(self, k: int, shown: Shown) -> float:
        place, question = self.places[k], self.questions[k]
        variants = place.rivals or (np.zeros(0, dtype=np.intp),)
        parts = [_outside(shown.gram, place.own, np.unique([*place.beside, *r])) for r in variants]
        if question.kind == "value":
            known = 1 / question.std**2
            variance = np.linalg.pinv(parts[0])[question.parameter, question.parameter]
            new = 1 / variance if variance > 0 and parts[0][question.parameter, question.parameter] > 0 else 0.0
            return float(self.sizes[k][question.parameter] ** 2 * (known + new))
        size = self.sizes[k]
        if question.sizes:
            return float(max(0.0, min(size @ part @ size for part in parts)))
        return float(max(0.0, min(np.mean(size**2 * np.diag(part)) for part in parts)))

    def _power(self, k: int, noncentrality: float, samples: Array) -> float:
        if self.questions[k].kind == "value":
            # the standard error itself is known to 1 / sqrt(2 N)
            ratio = np.sqrt(noncentrality) * VAGUE / HALF
            return float(norm.cdf((ratio - 1) * np.sqrt(2 * self._worth(k, samples))))
        return _power_of_f(noncentrality, len(self.places[k].own), self._worth(k, samples))

    def _at_power(self, k: int, samples: Array, power: float) -> float:
        """The noncentrality that reaches a power."""
        if self.questions[k].kind == "value":
            return float((HALF / VAGUE * (1 + norm.ppf(power) / np.sqrt(2 * self._worth(k, samples)))) ** 2)
        size, worth = len(self.places[k].own), self._worth(k, samples)
        root: Any = brentq(lambda x: _power_of_f(x, size, worth) - power, 0.0, LARGE)
        return float(root)

    def _worth(self, k: int, samples: Array) -> float:
        """Independent samples on a question's joints."""
        return max(4.0, float(samples[self.places[k].joints].sum()))


def _power_of_f(noncentrality: float, columns: int, samples: float) -> float:
    """How often N log(1 + F k / N) exceeds the evidence that a diagnosis requires, F noncentral with k and N degrees of freedom."""
    threshold = samples / columns * float(np.expm1(EVIDENCE / samples))
    if noncentrality < SMALL:
        return float(f.sf(threshold, columns, samples))
    if noncentrality > LARGE:  # of it, the threshold is a small part
        return 1.0
    return float(ncf.sf(threshold, columns, samples, noncentrality))


def _outside(gram: Array, own: NDArray[np.intp], beside: NDArray[np.intp]) -> Array:
    """The products (k, k) of some columns' parts outside others."""
    G = gram[np.ix_(own, own)]
    beside = np.setdiff1d(beside, own).astype(np.intp)
    beside = beside[np.diag(gram)[beside] > 0]
    if not len(beside):
        return G
    size = np.sqrt(np.diag(gram)[beside])
    H = gram[np.ix_(beside, beside)] / np.outer(size, size) + RIDGE * np.eye(len(beside))
    X = gram[np.ix_(beside, own)] / size[:, None]
    return G - X.T @ np.linalg.solve(H, X)


def _same_shape(a: Effect, b: Effect) -> bool:
    """Whether two effects have the same shape parameters, where either has any."""
    fields = [shape.field for shape in a.shape_parameters]
    return all(
        (x := getattr(a, field)) == (y := getattr(b, field)) or (x and y and len(set(x) | set(y)) == 1)
        for field in fields
    )
