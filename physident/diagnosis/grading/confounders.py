"""What else differs between before and after, and changes friction by itself: temperature, and the time since the start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from physident.diagnosis.result.findings import Finding
from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import Family
from physident.effects.thermal import NOTICEABLE_WARMING
from physident.recordings.recording import Recording

BY_ITSELF = (
    "a healthy arm's friction differs by some per cent from day to day, so a small change is a fault only if it stays"
)
UNKNOWN = f"no temperature was recorded: {BY_ITSELF}"
PARTLY_KNOWN = f"not every recording before and after has a temperature: {BY_ITSELF}"
NOTICEABLE_TIME = 60.0  # s: gears warm up over minutes, and less than one makes no difference that friction would show


def with_confounder(
    findings: Sequence[Finding], before: Sequence[Recording], after: Sequence[Recording]
) -> tuple[Finding, ...]:
    """The findings, those of friction, or that may be friction, with what differs between the recordings before and after and could be
    their reason."""
    text = friction_confounder(before, after)
    friction = {name for name, effect in CATALOGUE.items() if effect.family is Family.FRICTION}
    return tuple(
        replace(f, confounder=text) if friction & {f.effect, *(r.effect for r in f.rivals)} else f for f in findings
    )


def friction_confounder(before: Sequence[Recording], after: Sequence[Recording]) -> str:
    """What differs in words: the temperatures where all recordings have them, else the times on their clocks; empty where neither
    does, or there is nothing to compare with."""
    if not before or not after:
        return ""
    groups = (before, after)
    if all(one.temperature is not None for group in groups for one in group):
        cold, warm = (np.mean([_mean(one.temperature) for one in group]) for group in groups)
        if abs(warm - cold) <= NOTICEABLE_WARMING:
            return ""
        return (
            f"the arm was at {cold:.0f} degC before and is at {warm:.0f} degC now, which changes friction by itself: compare at one"
            " temperature"
        )
    early, late = (float(np.mean([_mean(one.time) for one in group])) for group in groups)
    if abs(late - early) <= NOTICEABLE_TIME:
        some = any(one.temperature is not None for group in groups for one in group)
        return PARTLY_KNOWN if some else UNKNOWN
    return (
        f"by their clocks the recordings lie {_ago(early, late)}, and an arm that warms up loses friction by itself: record after the"
        " same time"
    )


def _mean(values: np.ndarray | None) -> float:
    return float("nan") if values is None else float(np.mean(values))


def _ago(early: float, late: float) -> str:
    minutes = abs(late - early) / 60
    return f"{minutes:.0f} min {'later' if late > early else 'earlier'} after the start than those before"
