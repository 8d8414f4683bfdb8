"""A designed motion: what it reaches, its margins to all limits, and a verdict in words."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from physident.excitation.limits.limit import Margin
from physident.excitation.limits.self_collision import ExcludedPair
from physident.excitation.motion.series import Series
from physident.excitation.motion.trajectory import Trajectory
from physident.excitation.task import CHECKED, UNSCALED, Task
from physident.identifiability.manipulability import Manipulability
from physident.large_arrays import magnitude
from physident.notebook import results_html
from physident.recordings.signals import MOVING_SPEED

Limits = Literal["all", "joint"]
LIMITS: tuple[Limits, ...] = ("all", "joint")
SCHEMA = "physident.design/1"
BANDS = ((20.0, "good"), (100.0, "usable"))  # of the condition number of unscaled columns


@dataclass(frozen=True, eq=False, kw_only=True)
class Design:
    """A designed motion and what is known about it.

    ``condition`` is cond(Y) of ``columns`` columns, weighted as ``weighting`` describes, over 1,000 instants of a period;
    ``value`` is the criterion's. ``margins`` are those to every limit; ``excluded`` are the pairs of links that are not kept
    apart. ``starts`` are the criterion's values that the starts within the limits reached, best first. ``iterates``
    (K, n m) are the series' free numbers after each iteration that led to the motion, first those of the ``generations``
    of the genetic algorithm. ``seconds`` is wall-clock time, ``processor_seconds`` processor time.
    """

    trajectory: Trajectory
    criterion: str
    value: float
    condition: float
    columns: int
    weighting: str
    limits: Limits
    margins: tuple[Margin, ...]
    excluded: tuple[ExcludedPair, ...]
    manipulability: Manipulability
    starts: tuple[float, ...]
    task: Task
    iterates: NDArray[np.float64]
    generations: int
    seed: int
    seconds: float
    processor_seconds: float

    @property
    def active(self) -> tuple[Margin, ...]:
        """The limits that shaped the motion."""
        return tuple(one for one in self.margins if one.active)

    @cached_property
    def progress(self) -> tuple[float, ...]:
        """The condition number after each iteration: of the best motion of each generation, of the motion that IPOPT
        started from, and after each of its iterations."""
        t = self.trajectory
        return self.task.conditions(Series(t.n, t.harmonics, t.base_frequency), self.iterates)

    def as_dict(self) -> dict[str, Any]:
        """All results, for JSON (schema physident.design/1)."""
        plain = (
            "criterion",
            "value",
            "condition",
            "columns",
            "weighting",
            "limits",
            "seed",
        )  # without the time it took: the same design is the same file
        return {
            "schema": SCHEMA,
            **{key: getattr(self, key) for key in plain},
            "margins": [asdict(one) for one in self.margins],
            "excluded_pairs": [str(pair) for pair in self.excluded],
            "manipulability": self.manipulability.as_dict(),
            "starts": list(self.starts),
            "generations": self.generations,
            "progress": list(self.progress),
            "trajectory": self.trajectory.as_dict(),
        }

    @property
    def summary(self) -> str:
        """What the motion reaches and its margins, without a verdict."""
        t = self.trajectory
        periods = t.duration * t.base_frequency
        rows = [
            f"Design: {t.n} joints, {t.harmonics} harmonics of {t.base_frequency:g} Hz, {periods:g} period{'s' if periods > 1 else ''} of {1 / t.base_frequency:.4g} s",
            f"  condition number {self.condition:.2f} ({self.columns} columns, {self.weighting}); criterion {self.criterion}",
            f"  found in {self.seconds:.1f} s ({self.processor_seconds:.1f} s of processor time), seed {self.seed},"
            f" {len(self.starts)} starts ended within the limits",
            "  limit            nearest on            reached     allowed      margin",
            *(self._limit_row(limit) for limit in dict.fromkeys(one.limit for one in self.margins)),
        ]
        if self.excluded:
            far = [str(pair) for pair in self.excluded if pair.largest_distance is not None]
            rows.append(f"  links not kept apart: neighbours{'; ' if far else ''}{'; '.join(far)}")
        return "\n".join([*rows, f"  {self.manipulability!r}"])

    @property
    def limits_verdict(self) -> str:
        """Which limits hold: only those that were checked."""
        if self.limits == "joint":
            return "the joints' limits hold, starts and ends at rest; torque, tool, table and links were not checked"
        return "every limit holds, starts and ends at rest"

    @cached_property
    def still_joints(self) -> tuple[int, ...]:
        """The joints (from 1) that hardly move: a sliding one shows its link's mass at rest, and none of its friction."""
        t = self.trajectory
        speed = magnitude(t.states(np.arange(CHECKED) / CHECKED / t.base_frequency).v)
        return tuple(j + 1 for j in np.flatnonzero(speed < MOVING_SPEED * self.task.model.robot.radian).tolist())

    def __repr__(self) -> str:
        band = next((name for limit, name in BANDS if self.condition <= limit), "poor")
        # the condition number of scaled columns has no usual size
        quality = f"{band}; " if self.weighting == UNSCALED else ""
        if self.still_joints:
            one = len(self.still_joints) == 1
            quality = (
                f"joint{'' if one else 's'} {', '.join(map(str, self.still_joints))} hardly move{'s' if one else ''}, which shows no friction"
                " there, so identify would refuse it; design with a model that has friction (--model); "
            )
        return f"{self.summary}\nverdict: {quality}{self.limits_verdict}"

    def _repr_html_(self) -> str:
        title, *_, verdict = repr(self).splitlines()
        head = ("limit", "where", "reached", "allowed", "margin", "unit", "shaped the motion")
        rows = [
            (
                m.limit,
                m.where,
                f"{m.reached:.4g}",
                f"{m.allowed:.4g}",
                f"{m.margin:.3g}",
                m.unit,
                "yes" if m.active else "",
            )
            for m in self.margins
        ]
        return results_html(f"{title}; condition number {self.condition:.2f}", head, rows, verdict)

    def _limit_row(self, limit: str) -> str:
        """The smallest margin to one limit, and where the limit was active."""
        margins = [one for one in self.margins if one.limit == limit]
        worst = min(margins, key=lambda one: one.margin / max(abs(one.allowed), 1e-9))
        active = [one.where.removeprefix("joint ") for one in margins if one.active]
        note = f"  active: {', '.join(active)}" if active else ""
        return f"  {limit:<16} {worst.where:<18} {worst.reached:10.4g} {worst.allowed:11.4g} {worst.margin:11.3g} {worst.unit:<8}{note}"
