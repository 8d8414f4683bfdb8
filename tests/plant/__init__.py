"""A robot arm of its own for tests: it hides physical effects in generated recordings.

It shares no code with the package that must find them: the UR5's URDF is read as text, the dynamics are pinocchio's, and
friction, drives, sensors, motions and control are written here.

    arm = hide(Arm(), "load_dependent_friction", 2, 0.08)
    made = record(arm, multisine(seed=1), Sensors(), seed=1)
    made.write_csv("run.csv")
"""

from __future__ import annotations

from tests.plant.arm import Arm, Contact, Hidden
from tests.plant.controller import Controller
from tests.plant.drives import Drives, Ripple
from tests.plant.dynamics import Run, simulate
from tests.plant.friction import Coupling, Friction
from tests.plant.hide import EFFECTS, hide
from tests.plant.inverse import torque_along
from tests.plant.motions import Multisine, PointToPoint, multisine, point_to_point
from tests.plant.record import Record, record
from tests.plant.sensors import Sensors

__all__ = [
    "EFFECTS",
    "Arm",
    "Contact",
    "Controller",
    "Coupling",
    "Drives",
    "Friction",
    "Hidden",
    "Multisine",
    "PointToPoint",
    "Record",
    "Ripple",
    "Run",
    "Sensors",
    "hide",
    "multisine",
    "point_to_point",
    "record",
    "simulate",
    "torque_along",
]
