"""Which effects of one joint are parts of one torque: its curves, and the laws of what they depend on.

A torque of several quantities is told as a sum of curves over one quantity each, and what pushes a joint one way as a curve and an offset.
"""

from __future__ import annotations

from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import Family, Scope
from physident.effects.measurement import TorqueOffset


def are_one_torque(first: str, second: str) -> bool:
    """Whether two effects of a joint, by their names, are parts of one torque: one is a learned curve, and the other is a curve too, a law
    of the same quantity, or an offset. Bristles that slide are friction over velocity, too."""
    one, other = (CATALOGUE.get(name) for name in (first, second))
    if one is None or other is None:
        return False
    if other.family is Family.LEARNED and one.family is not Family.LEARNED:
        one, other = other, one
    if one.family is not Family.LEARNED:
        return False
    friction = other.family is Family.FRICTION and other.scope is Scope.JOINT
    slides = one.variable == "velocity" and friction and other.variable is None
    return other.family is Family.LEARNED or other is TorqueOffset or one.variable == other.variable or slides
