"""Which effects of one joint are parts of one torque: its curves, and the laws of what they depend on.

A torque of several quantities is told as a sum of curves over one quantity each, and what pushes a joint one way as a curve and an offset. A
spring that is relaxed elsewhere than at zero is a stiffness and an offset.
"""

from __future__ import annotations

from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import Family, Scope
from physident.effects.elastic import JointSpring
from physident.effects.measurement import TorqueOffset


def are_one_torque(first: str, second: str) -> bool:
    """Whether two effects of a joint, by their names, are parts of one torque: one is a learned curve, and the other is a curve too, a law
    of the same quantity, or an offset; or one is a spring, and the other an offset. Bristles that slide are friction over velocity, too."""
    one, other = (CATALOGUE.get(name) for name in (first, second))
    if one is None or other is None:
        return False
    if {one, other} == {JointSpring, TorqueOffset}:
        return True
    if other.family is Family.LEARNED and one.family is not Family.LEARNED:
        one, other = other, one
    if one.family is not Family.LEARNED:
        return False
    friction = other.family is Family.FRICTION and other.scope is Scope.JOINT
    slides = one.variable == "velocity" and friction and other.variable is None
    return other.family is Family.LEARNED or other is TorqueOffset or one.variable == other.variable or slides


def is_curve_of(curve: str, law: str) -> bool:
    """Whether the first effect of a joint, by its name, is a learned curve over the quantity that the second, a ``law``, is of."""
    one, other = (CATALOGUE.get(name) for name in (curve, law))
    if one is None or other is None or one.family is not Family.LEARNED or other.family is Family.LEARNED:
        return False
    return one.variable is not None and one.variable == other.variable
