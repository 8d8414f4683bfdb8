"""Robots: joints, links, limits and drives, from a URDF, a DH table or a built-in description.

Every table is turned into a URDF first, so that kinematics are read in one place. Start with ``robot.load_robot``.
"""
