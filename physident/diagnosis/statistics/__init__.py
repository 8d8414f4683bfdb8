"""The statistics of a diagnosis: gains on left-out rows, and what chance alone would reach.

``left_out_gains`` scores all candidates at once, ``surrogates`` draws residuals without relation to the motion,
``noise_floor`` and ``intervals`` say how exact a result is. Start with ``left_out_gains``.
"""
