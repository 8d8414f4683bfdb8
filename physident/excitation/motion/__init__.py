"""Motions: finite Fourier series and point-to-point moves that start and end at rest.

``motion`` is what every motion can do, ``trajectory`` and ``point_to_point`` are the kinds, ``series`` the coefficients
that a search moves. Start with ``motion``.
"""
