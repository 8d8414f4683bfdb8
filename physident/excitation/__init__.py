"""Motions that excite an arm: what a joint is asked to follow, and how such a motion is found."""

from physident.excitation.motion import Extent, Motion
from physident.excitation.point_to_point import PointToPoint
from physident.excitation.trajectory import Trajectory, load_trajectory, random_trajectory

__all__ = ["Extent", "Motion", "PointToPoint", "Trajectory", "load_trajectory", "random_trajectory"]
