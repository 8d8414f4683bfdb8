"""What a session is expected to settle, in numbers and words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Effect
from physident.excitation.session.evidence import HALF, Evidence, Shown
from physident.excitation.session.outlook_text import NEVER
from physident.excitation.session.pieces import Piece
from physident.excitation.session.questions import Expectation, RangeQuestion
from physident.excitation.session.ranges import Ranges, covered

Array = NDArray[np.float64]
PURPOSES = {
    "fourier": "Fourier series: inertia, gravity, friction over velocity",
    "slow": "slow reversals: friction near standstill",
    "poses": "poses and pauses: gravity, breakaway, one friction level at each load",
    "again": "repeats {}: what the model lacks is in both and cancels, what has changed is left",
}
NAMED = 2  # questions at most beside each piece
NOTICED = 0.05  # of power: a smaller loss is not worth a word


def piece_purpose(piece: Piece) -> str:
    """What a piece of its kind is for."""
    return PURPOSES[piece.kind].format(piece.repeats)


def worse_without(evidence: Evidence, every: Shown, one: Shown) -> tuple[str, ...]:
    """The questions whose power falls most without one piece, in words."""
    rest = Shown(every.gram - one.gram, every.samples - one.samples)
    if not len(evidence.questions) or not rest.samples.sum() > 0:
        return ()
    lost = evidence.powers(every) - evidence.powers(rest)
    order = [int(k) for k in np.argsort(-lost)[:NAMED] if lost[k] > NOTICED]
    return tuple(f"{evidence.questions[k].text} -{100 * lost[k]:.0f} %" for k in order)


def expectations_of(
    evidence: Evidence, shown: Shown, ranges: Sequence[RangeQuestion], joined: Ranges | None, possible: Ranges
) -> tuple[tuple[Expectation, ...], tuple[Effect, ...]]:
    """What is expected of every question and of every range; and the effects that no motion shows, which are no questions."""
    powers, smallest, found = evidence.powers(shown), evidence.smallest(shown), evidence.noncentralities(shown)
    result, hidden = [], []
    for k, question in enumerate(evidence.questions):
        if question.kind == "unseen" and smallest[k] > NEVER:
            hidden.append(question.effect)
            continue
        rival = question.rivals[0] if question.kind == "rival" else None
        result.append(
            Expectation(
                kind=question.kind,
                question=question.text,
                effect=question.effect.name,
                joints=question.effect.joints or (),
                rival="" if rival is None else rival.name,
                rival_joints=() if rival is None else rival.joints or (),
                parameter=question.parameter,
                size=abs(float(evidence.sizes[k][question.parameter])),
                power=float(powers[k]),
                smallest=float(smallest[k]),
                detail=_detail(evidence, k, float(found[k]), float(smallest[k])),
            )
        )
    share = covered(ranges, joined, possible)
    of_ranges = (_of_range(one, float(part)) for one, part in zip(ranges, share, strict=True))
    return (*result, *of_ranges), tuple(hidden)


def _of_range(one: RangeQuestion, share: float) -> Expectation:
    return Expectation(
        kind="range", question=one.text, effect="", joints=(one.joint,), power=share,
        smallest=float("inf"), detail=f"{100 * share:.0f} % of what is wanted",
    )  # fmt: skip


def _detail(evidence: Evidence, k: int, noncentrality: float, smallest: float) -> str:
    """The size that is assumed, and what else the number rests on."""
    question, sizes = evidence.questions[k], evidence.sizes[k]
    if not sizes.any():
        return "no motion within the limits shows it"
    if question.kind == "value":
        half = 100 * HALF / np.sqrt(noncentrality) if noncentrality > 0 else float("inf")
        before = 100 * HALF * question.std / abs(sizes[question.parameter])
        return f"half of its interval from {before:.0f} to {half:.0f} % of the value"
    columns = question.effect.columns(evidence.model.robot)
    if smallest > NEVER:
        return "no motion within the limits shows it beside the rest"
    if len(columns) > 1:
        return f"80 % power at {smallest:.2g} times {'its size' if question.sizes else 'the size of the noise'}"
    size = abs(float(sizes[0]))
    known = "as diagnosed" if question.sizes else "as large as the noise"
    unit = next(column.unit for column in columns)
    number = f"{size:.3g} {unit}".removesuffix(" 1")
    return f"at {number}, {known}; 80 % power from {smallest * size:.2g}"
