"""Open questions: what a session is to settle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from physident.effects.catalogue import effect_label
from physident.effects.effect import Effect

Array = NDArray[np.float64]
Kind = Literal["rival", "doubt", "shape", "unseen", "value", "parameter", "range"]
Quantity = Literal["position", "speed", "load"]
VAGUE = 0.1  # of a value: half of the 95 % interval of a value that is known well enough to be used


@dataclass(frozen=True, kw_only=True, eq=False)
class OpenQuestion:
    """Something about an ``effect`` that recordings have left open.

    "rival": whether it is not one of the ``rivals`` (variants of one other effect); "doubt": whether a finding that is less than a
    cause is one; "shape": whether its shape is not one of
    these; "unseen": whether it is there at all; "parameter": how large it is, of an effect that the model has, before anything was recorded;
    "value": its ``parameter`` (index of a column) to a tenth, where the standard error is
    ``std`` now. ``sizes`` (k,) are its parameters' sizes, empty where they are unknown: the effect is then taken to be as large as the
    noise.
    """

    kind: Kind
    effect: Effect
    rivals: tuple[Effect, ...] = ()
    sizes: tuple[float, ...] = ()
    parameter: int = 0
    std: float = float("inf")

    @property
    def model_fixed(self) -> bool:
        """Whether the model is fixed instead of refitted: a refitted one contains any change of a link or of all friction."""
        return any(one.within_model for one in (self.effect, *self.rivals))

    @property
    def text(self) -> str:
        """The question in words."""
        what = named(self.effect)
        if self.kind == "rival":
            return f"{what}, or {named(self.rivals[0])}?"
        known = {
            "shape": f"the shape of {what}",
            "unseen": f"{what}: is it there?",
            "doubt": f"{what}: is it a cause?",
            "parameter": f"{what}: how large?",
        }
        return known.get(self.kind, f"the value of {what}")


@dataclass(frozen=True, kw_only=True)
class RangeQuestion:
    """A range of one joint's (from 1) ``quantity`` of which recordings showed the share ``shown`` of what is possible."""

    joint: int
    quantity: Quantity
    shown: float

    @property
    def text(self) -> str:
        """The question in words."""
        return f"the {self.quantity} range of joint {self.joint} ({100 * self.shown:.0f} % shown so far)"


@dataclass(frozen=True, kw_only=True)
class Expectation:
    """What a session is expected to say to a question: the ``power`` (0 to 1) to settle it, of a range the share of what is wanted,
    and ``detail`` in words.

    ``smallest`` is the share of the assumed size that would still be found with a power of 80 %, infinite for never; it is not known for
    a range. ``size`` is that of the first parameter that is assumed. ``effect``, ``joints``, ``rival`` and ``rival_joints`` name the question for later.
    """

    kind: Kind
    question: str
    effect: str
    joints: tuple[int, ...]
    rival: str = ""
    rival_joints: tuple[int, ...] = ()
    parameter: int = 0
    size: float = 0.0
    power: float
    smallest: float
    detail: str

    @property
    def settled(self) -> float:
        """How much of an answer is expected: the power, and of a range an answer only where all that is wanted is shown."""
        return float(self.power >= 1) if self.kind == "range" else self.power

    def as_dict(self) -> dict[str, Any]:
        """The expectation as JSON can hold it."""
        return {**vars(self), "smallest": self.smallest if np.isfinite(self.smallest) else None}


def named(effect: Effect) -> str:
    """An effect and where it acts, in words."""
    joints = effect.joints or ()
    if not joints:
        return effect_label(effect.name)
    noun = effect.scope.noun
    return f"{effect_label(effect.name)} on {noun}{'s' if len(joints) > 1 else ''} {' and '.join(map(str, joints))}"
