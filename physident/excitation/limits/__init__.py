"""Limits of a motion: joints, torque, tool, table and the arm's own links.

``joint_limits`` and ``walls`` steer the search, ``margins`` checks its result by what did not design it. Start with
``margins``.
"""
