"""Robots: joints, links, limits and drives, from a URDF, a DH table or a built-in description.

A DH table is converted to a URDF first, so that kinematics are read in one place. Start with ``load.load_robot``.
"""
