"""Identifiability: which parameters torques can show at all, and which ones given recordings show.

``base_parameters`` finds the independent combinations of parameters, ``visibility`` and ``identifiability`` measure how
much of an effect lies outside the others. Start with ``base_parameters``.
"""
