"""Dynamics: the torque of a robot with its effects, and the regressor that is linear in their parameters.

``model.Model`` sums the effects; ``regressor.build_regressor`` evaluates their columns along recordings, filtered and
compressed. ``rigid_body_regressor`` and ``inverse_dynamics`` are the equations of motion. Start with ``model``.
"""
