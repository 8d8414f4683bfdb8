"""Limits of a motion: each joint's position, speed and acceleration, and everything that the workspace adds.

``joint_limits``, ``torque_limit``, ``tool_speed_limit``, ``table_limit`` and ``self_collision`` are the limits. Each one is
a constraint for the search and a margin for the check afterwards. ``workspace`` puts them together. Start with ``limit``.
"""
