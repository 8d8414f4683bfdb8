"""Which sign and order of the channels fits the description: efforts turned over, efforts of other joints, joints in another order.

Every channel of effort is held against every joint. A hypothesis says which joint each channel belongs to, and with which
sign. It is stated if it leaves at most half of the variance that the recording as it is leaves, on each joint that it
changes, and if that does not hang on one block of time.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.setup_checks.finding import SetupFinding, joint_list, within
from physident.setup_checks.joint_fit import CERTAIN, Moments, dissipation, moments_of, own_unexplained, unexplained
from physident.setup_checks.rows import Rows

Array = NDArray[np.float64]
Order = NDArray[np.intp]
TWICE = float(np.log(2.0))  # a mistake is stated where it explains away half of what is left, and more
THRICE = float(np.log(3.0))  # over all joints together, where each has other positions too
LOSS = float(np.log(1.5))  # what a joint may lose by a hypothesis about all joints


@dataclass(frozen=True, eq=False, kw_only=True)
class Hypothesis:
    """Channel i belongs to joint ``order[i]`` (n,), with ``sign[i]`` (n,) of 1 or -1; ``whole``: one mistake of all channels."""

    order: Order
    sign: Array
    whole: bool = False

    @property
    def changed(self) -> NDArray[np.bool_]:
        """The channels (n,) that it says something about."""
        return (self.order != np.arange(len(self.order))) | (self.sign < 0)

    def gains(self, shares: tuple[Array, Array]) -> Array:
        """Logarithm (n,) of the share that a channel leaves as it is, over the share that it leaves by this hypothesis."""
        rows = np.arange(len(self.order))
        as_is = shares[0][rows, rows]
        by_it = np.where(self.sign > 0, shares[0][rows, self.order], shares[1][rows, self.order])
        return np.log(np.maximum(as_is, CERTAIN) / np.maximum(by_it, CERTAIN))


def check_order(rows: Rows, moments: Moments) -> SetupFinding | None:
    """The sign or order of the effort channels that explains them, where the recording's own does not."""
    shares = unexplained(moments)
    # a small link's centre of mass may truly lie on the other side of its joint: its friction has to have the wrong sign too
    turnable = rows.strong() | (dissipation(rows, moments) < 0)
    others = [unexplained(moments, b) for b in range(moments.blocks)]
    convincing = [h for h in _simple(shares, turnable) if _convinces(h, h.gains(shares)) and _lasts(h, others)]
    general = _general(shares)
    convincing.sort(key=lambda h: -_total(h, shares))
    # a general order has many more ways to fit than a simple one, and has to be twice as good on one joint more
    margin = _total(convincing[0], shares) + TWICE if convincing else 0.0
    if (
        (general.order != np.arange(len(general.order))).any()
        and _convinces(general, general.gains(shares))
        and _total(general, shares) > margin
    ):
        convincing = [general] if _lasts(general, others) else convincing
    if not convincing:
        return None
    best = convincing[0]
    alike = [h for h in convincing[1:] if _total(h, shares) > _total(best, shares) - TWICE]
    rivals = [h for h in alike if (h.order != best.order).any() or (h.sign != best.sign).any()]
    finding = _finding(best, rivals, shares)
    return _or_positions(finding, rows, best, shares) if finding.kind == "effort_sign" else finding


def _or_positions(finding: SetupFinding, rows: Rows, best: Hypothesis, shares: tuple[Array, Array]) -> SetupFinding:
    """The finding about the efforts' sign, as one about the positions' where these explain more, or with them as its rival."""
    if _carries_as_described(rows, best):
        return _of_positions(finding)
    if best.whole:  # nobody turns all positions over
        return finding
    as_efforts = np.where(best.sign > 0, np.diag(shares[0]), np.diag(shares[1]))
    as_positions = own_unexplained(moments_of(rows.counted(best.sign)))
    gain = float(np.log(np.maximum(as_efforts, CERTAIN) / np.maximum(as_positions, CERTAIN)).sum())
    turned = best.sign < 0
    if gain > TWICE:
        return replace(
            finding,
            kind="position_sign",
            statement=f"{counts_the_other_way(finding.joints)}: turn the sign of q and dq over",
            evidence=f"the description leaves {100 * np.diag(shares[0])[turned].mean():.0f} % of the variance of their efforts as they are,"
            f" {100 * as_positions[turned].mean():.0f} % when corrected",
        )
    return (
        replace(finding, rivals=(*finding.rivals, counts_the_other_way(finding.joints))) if gain > -TWICE else finding
    )


def _carries_as_described(rows: Rows, turned: Hypothesis) -> bool:
    """Whether the joints whose efforts go against their motion carry a weight that never changes, such as a slide's, in the described
    direction: then it is their motion that is turned over."""
    described, measured = rows.gravity[:, turned.sign < 0], rows.torque[:, turned.sign < 0].mean(axis=0)
    weight = described.mean(axis=0)
    constant = np.ptp(described, axis=0) < CERTAIN * np.abs(weight)
    return bool((constant & (measured * weight > 0) & (np.abs(measured) > np.abs(weight) / 2)).all())


def _of_positions(finding: SetupFinding) -> SetupFinding:
    """The finding about the efforts' sign as one about the positions'."""
    return replace(
        finding,
        kind="position_sign",
        statement=f"{counts_the_other_way(finding.joints)}; its friction would drive the motion, while it carries its weight as described:"
        " turn the sign of q and dq over",
    )


def counts_the_other_way(joints: Sequence[int]) -> str:
    """In words, that positions of joints (from 1) have the wrong sign."""
    return f"the position of {joint_list(joints)} counts the other way"


def check_labels(rows: Rows, moments: Moments, than: float = 0.0) -> SetupFinding | None:
    """The order of joints, positions and efforts alike, with which the description explains the efforts; None where it gains
    no more ``than`` another mistake does."""
    n = rows.robot.n
    as_is = own_unexplained(moments)
    found: tuple[float, Order, Moments] | None = None
    for order in _orders(n):
        relabelled = rows.relabelled(order)
        other = moments_of(relabelled)
        gains = _label_gains(moments, other, order, None)
        # friction explains much of any joint: the order shows where inertia and gravity are large
        total, strong = float(gains.sum()), float(gains[relabelled.strong()].sum())
        if gains.min() > -LOSS and strong > TWICE and total > max(THRICE, than) and (found is None or total > found[0]):
            found = (total, order, other)
    if found is None:
        return None
    _, order, other = found
    if min(float(_label_gains(moments, other, order, b).sum()) for b in range(moments.blocks)) < TWICE:
        return None
    joints = tuple(int(j) + 1 for j in np.flatnonzero(order != np.arange(n)))
    mean = 100 * float(own_unexplained(other).mean())
    return SetupFinding(
        kind="joint_order",
        joints=joints,
        statement=f"{joint_list(joints)} are {'swapped' if len(joints) == 2 else 'in reverse order'} against the description, positions"
        " and efforts alike; correct the order of the columns",
        evidence=f"in that order the description leaves {mean:.0f} % of the variance instead of {100 * as_is.mean():.0f} %, mean over joints",
        void=True,
    )


def _label_gains(moments: Moments, other: Moments, order: Order, block: int | None) -> Array:
    as_is, by_it = own_unexplained(moments, block)[order], own_unexplained(other, block)
    return np.log(np.maximum(as_is, CERTAIN) / np.maximum(by_it, CERTAIN))


def _total(hypothesis: Hypothesis, shares: tuple[Array, Array]) -> float:
    return float(hypothesis.gains(shares).sum())


def _lasts(hypothesis: Hypothesis, others: Sequence[tuple[Array, Array]]) -> bool:
    """Whether a hypothesis is twice as good whichever block of time is left out."""
    return all(_total(hypothesis, shares) > TWICE for shares in others)


def _convinces(hypothesis: Hypothesis, gains: Array) -> bool:
    changed = gains[hypothesis.changed]
    if hypothesis.whole and len(gains) > 1:
        # of all joints together: one whose torque hardly follows the description may be undecided
        return bool(changed.mean() >= TWICE and changed.min() > -LOSS)
    if len(changed) == 2:
        return bool(changed.sum() >= 2 * TWICE and changed.min() >= LOSS / 2)
    return bool(changed.min() >= TWICE)


def _simple(shares: tuple[Array, Array], turnable: NDArray[np.bool_]) -> Iterator[Hypothesis]:
    """All signs turned over; those of some ``turnable`` joints; two joints swapped; the order reversed or shifted."""
    n = len(shares[0])
    as_is, plus = np.arange(n), np.ones(n)
    yield Hypothesis(order=as_is, sign=-plus, whole=True)
    single = np.log(np.maximum(np.diag(shares[0]), CERTAIN) / np.maximum(np.diag(shares[1]), CERTAIN))
    turned = (single >= TWICE) & turnable
    if turned.any():
        yield Hypothesis(order=as_is, sign=np.where(turned, -plus, plus))
    for order in _orders(n):
        yield Hypothesis(order=order, sign=plus, whole=n > 3 and order[0] == n - 1 and order[1] == n - 2)
    for shift in range(1, n if n > 2 else 1):
        yield Hypothesis(order=np.roll(as_is, shift), sign=plus, whole=True)


def _orders(n: int) -> Iterator[Order]:
    """Two joints swapped, and all of them reversed."""
    for i, j in itertools.combinations(range(n), 2):
        order = np.arange(n)
        order[[i, j]] = j, i
        yield order
    if n > 3:
        yield np.arange(n)[::-1].copy()


def _general(shares: tuple[Array, Array]) -> Hypothesis:
    """The best of all orders and signs."""
    from scipy.optimize import linear_sum_assignment

    left = np.log(np.maximum(np.minimum(*shares), CERTAIN))
    _, order = linear_sum_assignment(left)
    rows = np.arange(len(order))
    return Hypothesis(order=order, sign=np.where(shares[0][rows, order] <= shares[1][rows, order], 1.0, -1.0))


def _finding(found: Hypothesis, rivals: Sequence[Hypothesis], shares: tuple[Array, Array]) -> SetupFinding:
    n = len(found.order)
    rows = np.flatnonzero(found.changed)
    joints = tuple(int(j) + 1 for j in rows)
    as_is = 100 * shares[0][rows, rows].mean()
    by_it = np.where(found.sign > 0, shares[0][np.arange(n), found.order], shares[1][np.arange(n), found.order])[rows]
    kind, cure = "effort_order", "correct the order of the effort columns"
    if (found.order == np.arange(n)).all():
        kind, cure = "effort_sign", "friction would drive the motion, or gravity lift the arm: turn the sign over"
    return SetupFinding(
        kind=kind,
        joints=joints,
        statement=f"{_statement(found)}; {cure}",
        evidence=f"the description leaves {as_is:.0f} % of their variance as they are, {100 * by_it.mean():.0f} % when corrected",
        void=True,
        rivals=tuple(_statement(rival) for rival in rivals),
    )


def _statement(found: Hypothesis) -> str:
    """A hypothesis in words."""
    n = len(found.order)
    turned = tuple(int(j) + 1 for j in np.flatnonzero(found.sign < 0))
    if (found.order == np.arange(n)).all():
        return f"the effort of {within(turned, n)} has the wrong sign"
    moved = tuple(int(j) + 1 for j in np.flatnonzero(found.order != np.arange(n)))
    signs = f", with the sign of {joint_list(turned)} turned over" if turned else ""
    reverse = (found.order == np.arange(n)[::-1]).all() and n > 2
    how = "in reverse order" if reverse else f"in another order: {_mapping(found.order)}"
    how = "swapped" if len(moved) == 2 else how
    return f"the efforts of {joint_list(moved)} are {how}{signs}"


def _mapping(order: Order) -> str:
    """Which joint each moved channel belongs to, in words."""
    return ", ".join(f"column {k + 1} is joint {order[k] + 1}" for k in range(len(order)) if order[k] != k)
