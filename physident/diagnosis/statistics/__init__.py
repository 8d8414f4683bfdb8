"""The statistics of a diagnosis: gains on left-out rows, and what chance alone would reach.

``left_out_gains`` scores all candidates at once, ``surrogates`` draws residuals without relation to the motion, ``thresholds`` say what these reach,
``noise_floor`` and ``intervals`` compute noise and confidence intervals. Start with ``left_out_gains``.
"""
