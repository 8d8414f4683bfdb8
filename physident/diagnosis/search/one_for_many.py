"""One effect for many: several accepted effects give way to one that explains the data about as well with fewer numbers.

A forward search on a model that is wrong in many small ways ends in a patchwork: link inertia of three links and the friction of
two joints stand for a payload. Every candidate is tried in the place of those accepted effects that it makes superfluous, and
the shorter description of the data wins.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate
from physident.diagnosis.search.acceptance import is_admissible, is_as_good
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.search.left_out_costs import contradicted, left_out_costs
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.diagnosis.statistics.product_fit import Chosen, ProductFit, best_alone, fit_chosen
from physident.diagnosis.statistics.stored_products import Key, Products, StoredProducts, store_products
from physident.identifiability.visibility import VISIBLE

Array = NDArray[np.float64]
TRIED = 24  # candidates: one that stands for a patchwork is among those that explain most alone
TAKEN_OVER = 0.5  # of what an effect explains: a candidate that leaves it more does not stand for it


@dataclass(frozen=True, kw_only=True, eq=False)
class Replacement:
    """One candidate for several accepted effects: what is then ``accepted``, and what it ``replaces``."""

    accepted: tuple[AcceptedEffect, ...]
    replaces: tuple[AcceptedEffect, ...]


def find_replacement(hypothesis: Hypothesis, kept: Sequence[AcceptedEffect] = ()) -> Replacement | None:
    """The candidate that replaces two or more accepted effects, or one of more numbers, and leaves the shortest description.

    None where the data object to every candidate. Effects in ``kept``, and contacts, stay.
    """
    present = [a for a in hypothesis.accepted if a.candidate is not CONTACT]
    movable = {a.candidate.key for a in present} - {one.candidate.key for one in kept}
    if not movable:
        return None
    length = _length(hypothesis, present)
    found = []
    for new in best_alone(length.stored, length.fit(length.unmoved(movable)), TRIED, set(length.price), VISIBLE):
        change, gone = _shortest(length, new, movable)
        numbers = sum(length.numbers[key] for key in gone)
        if change < 0 and (len(gone) > 1 or numbers > length.size(new)):
            found.append((change, new, gone))
    for _, new, gone in sorted(found, key=lambda one: one[0]):
        rest = [a for a in hypothesis.accepted if a.candidate.key not in gone]
        beside = state_hypothesis(hypothesis.problem, rest, hypothesis.model, hypothesis.data)
        (candidate,) = (c for c in beside.data.candidates if c.key == new.key)
        if is_admissible(beside, candidate) and (len(gone) > 1 or _is_as_good(hypothesis, beside, candidate)):
            replaces = tuple(a for a in hypothesis.accepted if a.candidate.key in gone)
            return Replacement(
                accepted=(*rest, AcceptedEffect(candidate, refine_shape(beside, candidate))), replaces=replaces
            )
    return None


@dataclass(frozen=True, kw_only=True, eq=False)
class _Length:
    """The description length of the data beside the ``present`` effects: N log of what is left, and the price of numbers.

    A number costs the logarithm of the independent rows (Schwarz, 1978), a place twice that of how many there are to choose from.
    """

    whole: Hypothesis
    stored: StoredProducts
    products: Products
    present: tuple[Chosen, ...]
    numbers: dict[Key, int]

    def size(self, one: Chosen) -> int:
        """How many numbers an effect chooses."""
        return len(one.columns) + (len(self.stored.options[one.key]) > 1)

    @cached_property
    def price(self) -> dict[Key, float]:
        """What each present effect costs."""
        return {key: self.cost(count) for key, count in self.numbers.items()}

    def cost(self, numbers: int) -> float:
        """What an effect of so many numbers must explain to be worth them."""
        return numbers * float(np.log(max(self.products.worth.mean(), 2.0))) + 2 * float(
            np.log(len(self.stored.options))
        )

    def unmoved(self, movable: Collection[Key]) -> list[Chosen]:
        """The present effects without those that may be replaced."""
        return [one for one in self.present if one.key not in movable]

    def fit(self, chosen: Sequence[Chosen]) -> ProductFit:
        """The joint fit of some effects to all rows."""
        return fit_chosen(self.stored, self.products, chosen, self.whole)

    def left(self, fit: ProductFit) -> float:
        """Twice the negative log likelihood of what a fit leaves, and of what earlier rows said of the model."""
        return float(np.sum(self.products.worth * 2 * np.log(fit.fit.sigma))) + fit.contradicted

    def losses(self, chosen: Sequence[Chosen], fit: ProductFit) -> dict[Key, float]:
        """What would be lost without each of some effects while all else is refitted, to second order."""
        H, R, at, result = fit.fit.normal, self.stored.baseline, 0, dict[Key, float]()
        S = H[R:, R:] - H[R:, :R] @ pseudo_inverse(H[:R, :R]) @ H[:R, R:]
        for one in chosen:
            mine = np.arange(at, at + len(one.columns))
            x, at = fit.fit.x[R + mine], at + len(mine)
            others = np.delete(np.arange(len(S)), mine)
            cross = S[np.ix_(mine, others)]
            left = S[np.ix_(mine, mine)] - cross @ pseudo_inverse(S[np.ix_(others, others)]) @ cross.T
            result[one.key] = float(x @ left @ x)
        return result


def _length(hypothesis: Hypothesis, present: Sequence[AcceptedEffect]) -> _Length:
    stored = store_products(hypothesis)
    return _Length(
        whole=hypothesis,
        stored=stored,
        products=stored.over(range(stored.units)),
        present=tuple(Chosen(a.candidate.key, *stored.options[a.candidate.key][0]) for a in present),
        numbers={a.candidate.key: a.candidate.size for a in present},
    )


def _is_as_good(before: Hypothesis, beside: Hypothesis, candidate: Candidate) -> bool:
    """Whether left-out rows do not object to one candidate in the place of one effect of more numbers."""
    return is_as_good(beside, candidate, left_out_costs(before, None), before.fit.weights, contradicted(before, None))


def _shortest(length: _Length, new: Chosen, movable: Collection[Key]) -> tuple[float, set[Key]]:
    """By how much the description is longer with a candidate and without what it makes superfluous, and what that is.

    An effect is replaced only where the candidate takes over most of what it explains; what was not worth its price before
    counts for what it explained.
    """
    plain = length.fit(length.present)
    worth = length.losses(length.present, plain)
    kept, gone = list(length.present), set[Key]()
    fit = length.fit([*kept, new])
    change = length.cost(length.size(new)) + length.left(fit) - length.left(plain)
    while True:
        losses = length.losses([*kept, new], fit)
        open_to_it = [one for one in kept if one.key in movable and losses[one.key] < TAKEN_OVER * worth[one.key]]
        if not open_to_it:
            return change, gone
        weakest = min(open_to_it, key=lambda one: losses[one.key] - length.price[one.key])
        less = [one for one in kept if one is not weakest]
        fitted = length.fit([*less, new])
        saved = min(length.price[weakest.key], worth[weakest.key])
        lost = length.left(fitted) - length.left(fit)
        if lost >= saved:
            return change, gone
        gone.add(weakest.key)
        kept, fit, change = less, fitted, change + lost - saved
