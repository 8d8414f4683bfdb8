"""Figures by matplotlib: recordings, designed motions and residuals, one function a figure.

Colours and names come from ``graphics.style``. Start with ``residual``.
"""
