"""How hard a contact pushes at most, of which several forces that overlap make the whole."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.effects.contact import Contact


def strongest_push(hypothesis: Hypothesis, accepted: Sequence[AcceptedEffect]) -> str:
    """The size of the largest force of all accepted contacts of a recording, and when it acts; empty where none is a contact.

    A push that grows and fades is told as a long force and a shorter one within: neither is the force, but their sum.
    """
    pieces, forces = list[tuple[float, float]](), list[np.ndarray]()
    for one in accepted:
        if isinstance(one.effect, Contact):
            at = hypothesis.accepted.index(one)
            pieces += one.effect.pieces()
            forces += list(hypothesis.effect_values[at].reshape(-1, 3))
    if not pieces:
        return ""
    edges = sorted({edge for piece in pieces for edge in piece})
    sums = [
        np.sum([force for (a, b), force in zip(pieces, forces, strict=True) if a <= start < b], axis=0)
        for start, _ in pairwise(edges)
    ]
    sizes = [float(np.linalg.norm(one)) for one in sums]
    strongest = int(np.argmax(sizes))
    x, y, z = sums[strongest]
    start, end = edges[strongest], edges[strongest + 1]
    return (
        f"The strongest push is {sizes[strongest]:.3g} N ({x:.3g}, {y:.3g}, {z:.3g}) in the base frame, from {start:.2f} to"
        f" {end:.2f} s."
    )
