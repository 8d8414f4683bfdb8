"""Validation: the error of a model on recordings that were not fitted.

``scores`` has the relative error and the gain of one model over another, ``comparison`` both models' torques on the rows
that count for both. Start with ``scores.validate``.
"""
