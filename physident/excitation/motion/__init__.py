"""Motions: finite Fourier series and point-to-point moves that start and end at rest.

``motion`` is the base class, ``trajectory`` and ``point_to_point`` are the two kinds. ``series`` maps the free numbers of a
search to a trajectory. Start with ``motion``.
"""
