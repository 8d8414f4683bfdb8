"""Every effect acts in the simulator as its model says, also one that states nothing but its column."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

import physident as pid
from physident.effects.friction import ViscousFriction
from physident.effects.inertia import RigidBody, RotorInertia
from physident.effects.scales.friction_level import FrictionLevel
from physident.simulation.integrate import integrate
from physident.simulation.simulate import simulate
from tests.simulated_arm import SMOOTH, arm, drive


@dataclass(frozen=True)
class SquareDrag(pid.Effect):
    """A minimal effect: it says what its column is, and nothing else."""

    name: ClassVar[str] = "square_drag"
    unit: ClassVar[str] = "N m s^2/rad^2"

    def values(self, robot, signals):
        return (signals.v * np.abs(signals.v)).T[self.active(robot)]


@dataclass(frozen=True)
class PoseInertia(pid.Effect):
    """A minimal effect that feels the acceleration, of another joint too."""

    name: ClassVar[str] = "pose_inertia"
    unit: ClassVar[str] = "kg m^2"

    def values(self, robot, signals):
        a = signals.a.T
        return ((2 + np.sin(signals.q.T)) * (a + 0.2 * np.roll(a, 1, axis=0)))[self.active(robot)]


@dataclass(frozen=True)
class LoadFriction(pid.Effect):
    """Friction that grows with the torque of inertia and gravity, which depends on the acceleration sought."""

    name: ClassVar[str] = "load_friction"
    unit: ClassVar[str] = "-"

    def values(self, robot, signals):
        raise AssertionError("a simulation must ask torque_at")

    def torque_at(self, robot, signals, state, load):
        return (np.tanh(signals.v / 0.01) * np.abs(load)).T[self.active(robot)]


def test_minimal_effects_work_in_the_simulator(ur5):
    motion = pid.random_trajectory(ur5, 9, base_frequency=0.2)
    for effect, value in ((SquareDrag(), 3.0), (PoseInertia(joints=(2, 4)), 0.4)):
        model = arm(ur5, SMOOTH, effect, theta=(np.full(len(effect.active(ur5)), value),))
        states = integrate(model, motion)
        np.testing.assert_allclose(drive(states), model.torque(states), atol=1e-5)
        without = integrate(arm(ur5), motion)
        assert np.abs(drive(states) - drive(without)).max() > 0.1


ON_THE_PLANT = [name for name, effect in pid.CATALOGUE.items() if effect.acts_on == "plant" and effect.pointwise]


@pytest.mark.parametrize("name", ON_THE_PLANT)
def test_every_effect_of_the_catalogue_acts_as_its_model_says(ur5, name):
    given = {"coulomb_friction": SMOOTH, "friction_level": FrictionLevel(smoothing=(0.01,), presliding=0.0)}
    effect = given.get(name) or pid.CATALOGUE[name].at_grid_middle(ur5)
    strength = np.full(len(effect.columns(ur5)), 0.1)
    base = [part for part in (RigidBody(), RotorInertia(), ViscousFriction(), SMOOTH) if part.name != name]
    nominal = pid.Model.nominal(ur5, base)
    model = pid.Model(ur5, (*base, effect), np.concatenate([nominal.theta, strength]))
    if name == "rigid_body":
        model = replace(nominal, effects=(*base, effect), theta=np.concatenate([nominal.theta, 1.1 * ur5.nominal]))
    motion = pid.random_trajectory(ur5, 9, base_frequency=0.4)
    states = integrate(model, motion, temperature=lambda time: 25.0 + 0.5 * np.tile(time[:, None], (1, 6)))
    np.testing.assert_allclose(drive(states), model.torque(states), atol=2e-5)


def test_friction_may_depend_on_the_load(ur5):
    motion = pid.random_trajectory(ur5, 9, base_frequency=0.2)
    states = integrate(arm(ur5, SMOOTH, LoadFriction(), theta=(np.full(6, 0.1),)), motion)
    plain = arm(ur5)
    load = pid.Model(ur5, plain.effects[:1], plain.theta[:60]).torque(states)  # without the rotors
    expected = plain.torque(states) + 0.1 * np.tanh(states.v / 0.01) * np.abs(load)
    np.testing.assert_allclose(drive(states), expected, atol=1e-5)


@dataclass(frozen=True)
class Broken(pid.Effect):
    name: ClassVar[str] = "broken"
    unit: ClassVar[str] = "N m"

    def values(self, robot, signals):
        return np.full((6, len(signals.time)), np.nan)


@dataclass(frozen=True)
class BrokenMeter(Broken):
    name: ClassVar[str] = "broken_meter"
    acts_on: ClassVar = "measurement"


def test_an_effect_that_is_no_number_is_refused(ur5):
    motion = pid.random_trajectory(ur5, 9, base_frequency=0.4)
    for effect, message in ((Broken(), "first state"), (BrokenMeter(), "broken_meter")):
        with pytest.raises(pid.PhysidentError, match=message):
            simulate(arm(ur5, SMOOTH, effect, theta=(np.ones(6),)), motion)
