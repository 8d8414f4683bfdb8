"""The physical effects a model is made of, one family a file."""

from physident.effects.catalogue import CATALOGUE, DEFAULT_EFFECTS, make_effects
from physident.effects.effect import Column, Cone, Effect

__all__ = ["CATALOGUE", "DEFAULT_EFFECTS", "Column", "Cone", "Effect", "make_effects"]
