"""Validation: the error of a model on recordings that were not fitted.

``predictions`` has the predicted torque of recordings, ``scores`` the relative error and the gain of one model over
another, ``comparison`` two models' predictions on the same rows. Start with ``scores.validate``.
"""
