"""The machine that a truth describes: every hidden effect turned into numbers of bodies, drives and friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.plant_mujoco.friction import Friction
from tests.plant_mujoco.tree import Tree, read_tree
from tests.truth import ArmTruth, Disturbance

Array = NDArray[np.float64]
WEIGHT = 9.81  # m/s^2
REFERENCE = 25.0  # degC


@dataclass(frozen=True)
class Ripple:
    """Torque ``amplitude`` sin(order q + phase) [N m] that the drive of a joint (from 0) must overcome."""

    joint: int
    amplitude: float
    order: float
    phase: float


@dataclass(frozen=True)
class Push:
    """Forces [N] on the surroundings in the base frame, each for an equal share of the time from ``start`` to ``end`` [s]."""

    start: float
    end: float
    forces: tuple[tuple[float, float, float], ...]

    def at(self, time: float) -> Array:
        """The force (3,) [N] at one time [s]."""
        share = (time - self.start) / (self.end - self.start) + 1e-9
        return np.array(self.forces[int(share * len(self.forces))]) if 0 <= share < 1 else np.zeros(3)


@dataclass(frozen=True)
class Coupling:
    """Dry friction [N m] and viscous friction [N m s/rad] of the summed motion of two joints (from 0), felt by both."""

    first: int
    second: int
    dry: float
    viscous: float


@dataclass(frozen=True, eq=False)
class Machine:
    """An arm of n joints with all its effects; rows are (n,), link parameters (10,) about the joint frame.

    ``drops`` are bodies (time [s], parameters) on the last link that are lost at their time. ``compliance`` [rad/(N m)]
    and ``play`` [rad] lie between rotor and link. ``fading`` are (row, time constant [s]) and ``per_kelvin`` rows that scale
    friction; ``rise`` is (temperature rise [K], time constant [s]). ``pendulum`` is (mass [kg], length [m]).
    """

    tree: Tree
    links: Array
    rotor: Array
    friction: Friction
    gravity: Array
    offset: Array
    constant: Array
    compliance: Array
    play: Array
    spring: Array
    zero: Array
    delay: Array | float = 0.0
    cool: Array | float = 1.0
    fading: tuple[tuple[Array, float], ...] = ()
    per_kelvin: tuple[Array, ...] = ()
    rise: tuple[float, float] = (0.0, 1.0)
    ripples: tuple[Ripple, ...] = ()
    pushes: tuple[Push, ...] = ()
    couplings: tuple[Coupling, ...] = ()
    drops: tuple[tuple[float, Array], ...] = ()
    pendulum: tuple[float, float] | None = None
    base: float = 0.0
    disturbances: tuple[Disturbance, ...] = ()

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.rotor)

    def warmed(self, time: Array) -> Array:
        """Rise of temperature (N, n) [K] since the start, at times (N,) [s]."""
        rise, constant = self.rise
        return np.tile(rise * -np.expm1(-time / constant), (self.n, 1)).T

    def warmth(self, time: Array) -> Array:
        """Factor (N, n) on coulomb, breakaway and viscous friction at times (N,) [s]."""
        factor = np.ones((len(time), self.n))
        for row, constant in self.fading:
            factor += row * np.exp(-time[:, None] / constant)
        for row in self.per_kelvin:
            factor += row * self.warmed(time)
        return np.maximum(self.cool * factor, 0.0)


def ordinary(arm: ArmTruth, warmer: float = 0.0) -> Machine:
    """The machine without the arm's hidden effects and disturbances, ``warmer`` [K] than the reference."""
    zero, f = np.zeros(arm.joints), arm.friction
    friction = Friction(
        kind=f.kind,
        coulomb=f.coulomb,
        viscous=f.viscous,
        breakaway=f.breakaway,
        stribeck_speed=f.stribeck_speed,
        bristle_stiffness=f.bristle_stiffness,
        bristle_damping=f.bristle_damping,
        width=f.width,
        asymmetry=zero,
        load=zero,
        hysteresis=zero,
        slip=np.ones(arm.joints),
    )
    tree = read_tree(arm.urdf, arm.tool)
    if len(tree.joints) != arm.joints:
        raise ValueError(f"{arm.name}: {len(tree.joints)} joints in the URDF, {arm.joints} in the truth")
    return Machine(
        tree=tree,
        links=np.asarray(arm.links, dtype=float),
        rotor=np.asarray(arm.rotor_inertia, dtype=float),
        friction=friction,
        gravity=np.array([0.0, 0.0, -WEIGHT]),
        offset=np.asarray(arm.torque_offset, dtype=float),
        constant=zero,
        compliance=zero,
        play=zero,
        spring=zero,
        zero=zero,
        cool=np.maximum(1.0 - np.asarray(f.per_degree) * warmer, 0.0),
    )
