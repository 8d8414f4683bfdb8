"""Choosing pieces within a budget of time: the one that adds most a second first, then exchanges while they help."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

Part = TypeVar("Part")
EXCHANGES = 2  # rounds over the chosen ones
ALIKE = 1e-9  # of a score: a smaller gain is rounding


def choose(
    parts: Sequence[Part],
    seconds: Sequence[float],
    budget: float,
    score: Callable[[list[Part]], float],
    start: Sequence[int] = (),
) -> list[int]:
    """Indices of the parts that raise a ``score`` most within a ``budget`` [s], in the order in which they were chosen.

    ``start`` are parts that are taken beforehand and not exchanged. A part may be chosen once.
    """
    chosen = list(start)
    spent = sum(seconds[i] for i in chosen)
    while True:
        now = score([parts[i] for i in chosen])
        fitting = [i for i in range(len(parts)) if i not in chosen and spent + seconds[i] <= budget + 1e-6]
        gains = [(score([parts[k] for k in [*chosen, i]]) - now) / seconds[i] for i in fitting]
        if not fitting or max(gains) <= ALIKE:
            break
        best = fitting[int(np.argmax(gains))]
        chosen.append(best)
        spent += seconds[best]
    return _exchanged(parts, seconds, budget, score, chosen, len(start))


def _exchanged(
    parts: Sequence[Part],
    seconds: Sequence[float],
    budget: float,
    score: Callable[[list[Part]], float],
    chosen: list[int],
    kept: int,
) -> list[int]:
    """The choice after exchanges of one part for another that raise the score."""
    now = score([parts[i] for i in chosen])
    for _ in range(EXCHANGES):
        before = now
        for place in range(kept, len(chosen)):
            rest = chosen[:place] + chosen[place + 1 :]
            room = budget - sum(seconds[i] for i in rest) + 1e-6
            fitting = [i for i in range(len(parts)) if i not in chosen and seconds[i] <= room]
            scores = [score([parts[k] for k in [*rest, i]]) for i in fitting]
            if fitting and max(scores) > now + ALIKE:
                now = max(scores)
                chosen = [*chosen[:place], fitting[int(np.argmax(scores))], *chosen[place + 1 :]]
        if now <= before + ALIKE:
            break
    return chosen
