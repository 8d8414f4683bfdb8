"""How hard a contact pushes: what forces that overlap make together."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from physident.diagnosis.result.contact_force import strongest_push
from physident.effects.contact import Contact


def test_of_forces_that_overlap_the_push_is_the_sum() -> None:
    """A push that grows and fades, told as a long force with a shorter one within."""
    effects = [Contact(intervals=((2.0, 5.0),), steady=True), Contact(intervals=((3.0, 4.0),), steady=True)]
    accepted = cast(Any, [SimpleNamespace(effect=one) for one in effects])
    told = cast(
        Any, SimpleNamespace(accepted=accepted, effect_values=[np.array([3.0, 0.0, 0.0]), np.array([0.0, 4.0, 0.0])])
    )
    expected = "The strongest push is 5 N (3, 4, 0) in the base frame, from 3.00 to 4.00 s."
    assert strongest_push(told, accepted) == expected
