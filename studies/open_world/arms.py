"""Random arms: the truth differs from the description, friction is of three kinds, and every one has a background."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from studies.open_world import background
from studies.open_world.descriptions import ARMS, TOOL, Description
from studies.open_world.scale import Scale, bodies, measure, pilot, scale_of
from tests.truth import ArmTruth, FrictionTruth

Array = NDArray[np.float64]
Rng = np.random.Generator
Kind = Literal["dry", "bristle", "smooth"]
FRICTIONS: tuple[Kind, ...] = ("dry", "bristle", "smooth")
SHARE = (0.2, 0.6)  # of a joint's RMS torque that friction is


@lru_cache(maxsize=64)
def arm(seed: int) -> ArmTruth:
    """An arm: two seeds in a row share a description, four descriptions and three kinds of friction take turns."""
    rng = np.random.default_rng([seed, 7])
    kinds = ARMS[seed // 2 % len(ARMS)]
    bare = _frictionless(kinds[int(rng.integers(len(kinds)))](), rng)
    states = pilot(bare, rng)
    scale = measure(bare, states)
    offset = 0.02 * scale.rigid * rng.standard_normal(bare.joints)
    whole = replace(bare, friction=_friction(FRICTIONS[seed % len(FRICTIONS)], scale, bare, rng), torque_offset=offset)
    return replace(whole, background=background.draw(whole, states, rng))


def _frictionless(description: Description, rng: Rng) -> ArmTruth:
    """The links and rotors as they truly are, without friction."""
    model = bodies(description.urdf)
    nominal = np.array([body.toDynamicParameters() for body in list(model.inertias)[1:]])
    n = len(nominal)
    none = np.zeros(n)
    truth = ArmTruth(
        name=description.name, urdf=description.urdf, tool=TOOL,
        links=np.array([_really(link, rng) for link in nominal]), rotor_inertia=none, torque_offset=none,
        friction=FrictionTruth(
            kind="smooth", coulomb=none, viscous=none, breakaway=none, stribeck_speed=none + 1, bristle_stiffness=none + 1,
            bristle_damping=none, width=none + 1, per_degree=none,
        ),
        lower=description.lower, upper=description.upper, top_speed=description.top_speed,
        top_acceleration=description.top_acceleration, bandwidth=float(rng.uniform(25.0, 60.0)),
    )  # fmt: skip
    scale = scale_of(truth)
    # small wrists have rotors that outweigh their links
    largest = np.where(scale.prismatic, scale.inertia, scale.inertia[~scale.prismatic].max())
    rotors = rng.uniform(0.2, 0.8, n) * scale.inertia + rng.uniform(0.01, 0.04, n) * largest
    return replace(truth, rotor_inertia=rotors)


def _really(link: Array, rng: Rng) -> Array:
    """A link (10,) as it was built: another mass, centre and size than its maker says, yet a body that can be."""
    mass, first = link[0], link[1:4]
    xx, xy, yy, xz, yz, zz = link[4:]
    com = first / mass
    about_com = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) - mass * (
        com @ com * np.eye(3) - np.outer(com, com)
    )
    true_mass = mass * rng.uniform(0.8, 1.25)
    true_com = com + rng.normal(0.0, 0.01, 3)
    turn, _ = np.linalg.qr(np.eye(3) + 0.1 * rng.standard_normal((3, 3)))
    size = rng.uniform(0.85, 1.2) ** 2 * true_mass / mass
    inertia = size * turn @ about_com @ turn.T + true_mass * (
        true_com @ true_com * np.eye(3) - np.outer(true_com, true_com)
    )
    return np.array(
        [true_mass, *(true_mass * true_com), inertia[0, 0], inertia[0, 1], inertia[1, 1], inertia[0, 2], inertia[1, 2], inertia[2, 2]]
    )  # fmt: skip


def _friction(kind: Kind, scale: Scale, arm: ArmTruth, rng: Rng) -> FrictionTruth:
    """Friction of some kind whose RMS is a random share of each joint's torque."""
    n = arm.joints
    share = rng.uniform(*SHARE, n)
    level = scale.rigid * share / np.sqrt(1 - share**2)  # friction and rigid torque hardly correlate
    dry = rng.uniform(0.4, 0.85, n)
    coulomb, viscous = dry * level, (1 - dry) * level / scale.speed
    slow = arm.top_speed / 1.5  # a sliding joint's speeds are smaller numbers than a turning one's
    return FrictionTruth(
        kind=kind,
        coulomb=coulomb,
        viscous=viscous,
        breakaway=coulomb * rng.uniform(1.0, 1.5, n),
        stribeck_speed=slow * _log(rng, 0.01, 0.08, n),
        bristle_stiffness=coulomb / (slow * _log(rng, 0.002, 0.02, n)),
        bristle_damping=viscous * rng.uniform(0.1, 0.6, n),
        width=np.full(n, _log(rng, 0.0005, 0.05, 1)[0]) * slow,
        per_degree=rng.uniform(0.003, 0.01, n) if rng.random() < 1 / 3 else np.zeros(n),
    )


def _log(rng: Rng, low: float, high: float, count: int) -> Array:
    """Drawn evenly on a logarithmic scale."""
    return np.exp(rng.uniform(np.log(low), np.log(high), count))
