"""Physical estimation: a convex program whose links are rigid bodies and whose friction dissipates.

``program`` states and solves it with cvxpy and Clarabel, ``cones`` are its constraints, ``prior`` keeps what the data do
not decide near the description, ``certificate`` proves the result. Start with ``consistent``, the estimator.
"""
