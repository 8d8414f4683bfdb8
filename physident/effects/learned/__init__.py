"""Curves that are learned where no law is known: smooth functions of one quantity of a joint, linear in their parameters.

``spline`` has the functions that a curve is a sum of and their roughness, ``curve`` the effect, ``curves`` one class for each quantity.
Start with ``curve``.
"""
