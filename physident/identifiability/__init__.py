"""Identifiability: what torques can show of a model at all, and what given recordings do show.

``base_parameters`` finds the independent combinations of parameters, ``visibility`` and ``identifiability`` measure how
much of an effect lies outside the others. Start with ``base_parameters``.
"""
