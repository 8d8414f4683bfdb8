"""The simulated arm: a robot with the effects of its model, tracked by a controller, read by sensors."""

from physident.simulation.controllers import PD, ComputedTorque, Controller, Released
from physident.simulation.integrate import integrate
from physident.simulation.sensors import Sensors, Warming, load_sensors
from physident.simulation.simulate import Simulation, simulate, simulate_many

__all__ = [
    "PD",
    "ComputedTorque",
    "Controller",
    "Released",
    "Sensors",
    "Simulation",
    "Warming",
    "integrate",
    "load_sensors",
    "simulate",
    "simulate_many",
]
