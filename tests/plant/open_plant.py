"""The plant on pinocchio for any arm that `tests.truth` describes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from tests.plant.arm import AMBIENT, Arm, described
from tests.plant.controller import Controller
from tests.plant.drives import Drives
from tests.plant.dynamics import simulate
from tests.plant.friction import Friction
from tests.plant.hide import EFFECTS, hide
from tests.plant.inverse import torque_along
from tests.plant.laws import Bristle, Dry, Law, Smooth
from tests.plant.report import reported
from tests.truth import ArmTruth, FrictionTruth, Motion, Run

Array = NDArray[np.float64]
STEP = 1.6e-3  # s: half of it changes the torque below 8 Hz by less than a hundredth of an ordinary instrument's noise
POSES = 30  # over which a joint's inertia is averaged for its gains


class PinocchioPlant:
    """Implements `tests.truth.Plant`; a hidden effect means what `tests.plant.hide` says."""

    name = "pinocchio"
    effects = frozenset(EFFECTS)

    def simulate(self, arm: ArmTruth, motion: Motion, *, warmer: float = 0.0, step: float | None = None) -> Run:
        """The arm following a motion from rest; ``warmer`` [K] than 25 degC, ``step`` [s] of the rows."""
        true = arm_of(arm, warmer)
        run = simulate(true, motion, controller_of(arm), step or STEP)
        torque = reported(true, run.time, run.q, run.v, run.torque)
        dry = isinstance(true.friction.law, Dry)
        temperature = true.temperature(run.time)
        shown = run.q - true.zero_offset
        return Run(run.time, shown, run.v, run.a, torque, temperature, run.stuck if dry else None)

    def torque_along(self, arm: ArmTruth, run: Run) -> Array:
        """Reported torque (N, n) [N m] that this arm needs for another run's motion, NaN where dry friction at rest takes
        any torque or where its drives cannot give it. How warm it is, the run's first temperature says."""
        true = arm_of(arm, float(run.temperature[0].mean()) - AMBIENT)
        return torque_along(true, run.time, run.q, run.v, run.a, run.at_rest, run.torque)


def arm_of(truth: ArmTruth, warmer: float = 0.0) -> Arm:
    """The arm as this plant knows it, with all its hidden effects."""
    n = truth.joints
    none = np.zeros(n)
    if described(truth.urdf).nv != n:
        raise ValueError(f"{truth.name}: {described(truth.urdf).nv} joints in the description, {n} rotors")
    arm = Arm(
        links=np.array(truth.links, dtype=float),
        friction=friction_of(truth.friction, warmer),
        drives=Drives(
            truth.rotor_inertia, none, torque_constant=none, torque_offset=truth.torque_offset, channel_delay=none
        ),
        spring=none,
        zero_offset=none,
        temperature_rise=none,
        disturbances=(*truth.background, *truth.disturbances),
        ambient=AMBIENT + warmer,
        description=truth.urdf,
        tool=truth.tool,
    )
    for effect in truth.effects:
        arm = hide(arm, effect.effect, effect.joints, effect.size, **effect.shape)
    # only now are the pairs of coupled friction known, which are elements of their own
    return replace(arm, friction=replace(arm.friction, law=_law(truth.friction, arm.friction)))


def friction_of(truth: FrictionTruth, warmer: float = 0.0) -> Friction:
    """Friction without hidden effects, which come in their full size however warm the arm is."""
    none = np.zeros(len(truth.coulomb))
    share = 1.0 - truth.per_degree * warmer
    if (share <= 0).any():
        raise ValueError(f"{warmer} K leave no friction")
    return Friction(
        viscous=share * truth.viscous, coulomb=share * truth.coulomb, asymmetry=none, stribeck=none, power=none,
        load_dependent=none, stiffness=none, warmth=none, warmth_per_degree=none,
        onset=share * (truth.breakaway - truth.coulomb), onset_speed=np.asarray(truth.stribeck_speed, dtype=float),
    )  # fmt: skip


def _law(truth: FrictionTruth, friction: Friction) -> Law:
    """The law near zero speed of every element; a coupled pair's is the mean of its joints'."""
    mean = friction.elements / friction.elements.sum(axis=1, keepdims=True)
    if truth.kind == "smooth":
        return Smooth(mean @ truth.width)
    if truth.kind == "bristle":
        return Bristle(mean @ truth.bristle_stiffness, mean @ truth.bristle_damping, mean @ truth.stribeck_speed)
    return Dry()


def controller_of(truth: ArmTruth) -> Controller:
    """Position control of the truth's bandwidth, which knows the description and the rotors, no friction and no effects."""
    bodies = described(truth.urdf).copy()
    bodies.armature[:] = truth.rotor_inertia
    inertia = _mean_inertia(bodies, truth.lower, truth.upper)
    stiffness, damping = truth.bandwidth**2 * inertia, 2 * truth.bandwidth * inertia
    return Controller(tuple(stiffness), tuple(damping), tuple(truth.rotor_inertia), bodies)


def _mean_inertia(bodies: Any, lower: Array, upper: Array) -> Array:
    """Inertia (n,) [kg m^2] of each joint alone, over poses spread evenly over its range."""
    data, n = bodies.createData(), bodies.nv
    golden = np.sqrt(np.arange(2, 2 + n) + 0.5) % 1  # irrational: a lattice that repeats no pose
    poses = lower + (upper - lower) * (np.outer(np.arange(1, POSES + 1), golden) % 1)
    return np.mean([np.diag(pin.crba(bodies, data, q)) for q in poses], axis=0)
