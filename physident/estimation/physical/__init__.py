"""Physically consistent estimation: a semidefinite program (SDP) whose links are rigid bodies and whose friction dissipates.

``problem`` states the convex problem, ``semidefinite_program`` solves it with cvxpy and Clarabel, ``certificate`` proves
the answer. ``cones`` and ``bounds`` are the constraints; ``prior`` keeps what the data do not determine near the robot's
description. Start with ``physical_fit``, the estimator.
"""
