"""How far an accepted effect can be trusted before it is graded."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Trust:
    """``stability``: the share of searches on halves that find it, None where it has none; ``doubts``: what makes it a hint."""

    stability: float | None = None
    doubts: tuple[str, ...] = ()


def with_doubt(trust: Trust | None, doubt: str) -> Trust:
    """The trust in an effect with one more doubt."""
    known = trust or Trust()
    return replace(known, doubts=(*known.doubts, doubt))
