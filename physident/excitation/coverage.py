"""A motion that goes where a learned curve has not been, and how far it gets."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from physident.excitation.design import Design


@dataclass(frozen=True, kw_only=True)
class Covered:
    """The range of one ``joint``'s (from 1) quantity, in its ``unit``: recorded ``before`` the motion, ``reached`` by it, and the
    ``possible`` one within the joint's limits."""

    joint: int
    unit: str
    before: tuple[float, float]
    reached: tuple[float, float]
    possible: tuple[float, float]

    @property
    def gap(self) -> tuple[float, float] | None:
        """What lies between the ranges before and by the motion and is in neither; None where they touch."""
        low, high = sorted((self.before, self.reached))
        return (low[1], high[0]) if high[0] > low[1] else None


@dataclass(frozen=True, eq=False, kw_only=True)
class Coverage:
    """A ``design`` that covers what the learned curves of an ``effect`` have not seen, and the ranges ``covered``."""

    effect: str
    design: Design
    covered: tuple[Covered, ...]

    def as_dict(self) -> dict[str, Any]:
        """The design and the ranges, for JSON (schema physident.design/1)."""
        return {**self.design.as_dict(), "effect": self.effect, "covered": [asdict(one) for one in self.covered]}

    def __repr__(self) -> str:
        rows = [
            f"  {one.joint:5d}  {_range(one.before)}  {_range(one.reached)}  {_range(one.possible)}  {one.unit}"
            for one in self.covered
        ]
        gaps = [
            f"; joint {one.joint} is then still unseen from {one.gap[0]:.3g} to {one.gap[1]:.3g} {one.unit}"
            for one in self.covered
            if one.gap is not None
        ]
        return "\n".join(
            [
                self.design.summary,
                f"Covers {self.effect}",
                f"  joint  {'recorded before':>18}  {'by this motion':>18}  {'possible':>18}",
                *rows,
                f"verdict: {self.design.limits_verdict}{''.join(gaps)}",
            ]
        )


def _range(ends: tuple[float, float]) -> str:
    return f"{f'{ends[0]:.3g} to {ends[1]:.3g}':>18}"
