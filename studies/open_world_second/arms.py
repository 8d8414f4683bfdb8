"""Arms as they truly are: bodies unlike their description, rotors, and friction of a drawn kind."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from studies.open_world_second.bodies import deformed, described, rigid, with_lump
from studies.open_world_second.description import TOOL, Segment, urdf
from studies.open_world_second.designs import DESIGNS
from tests.truth import ArmTruth, FrictionTruth

Array = NDArray[np.float64]
FRICTIONS: tuple[Literal["dry", "bristle", "smooth"], ...] = ("dry", "bristle", "smooth")
FORGOTTEN = 0.3  # share of arms with an adapter at the flange that nobody entered in the description
POSES = 300


def draw(seed: int) -> ArmTruth:
    """An arm without background; the design, its size, its bodies and its friction follow from the seed."""
    rng = np.random.default_rng([seed, 401])
    name = list(DESIGNS)[int(rng.integers(len(DESIGNS)))]
    design = DESIGNS[name]
    length = rng.uniform(0.85, 1.2)
    segments = tuple(part.scaled(length, length**2.5 * rng.uniform(0.8, 1.25)) for part in design.segments)
    x, y, z = (length * edge for edge in design.flange)
    text = urdf(name, segments, (x, y, z))
    links = _bodies(text, (x, y, z), rng)
    bounds = _bounds(segments)
    rotor = _rotors(text, links, bounds, rng)
    load = typical_load(text, links, rotor, bounds)
    slides = np.array([part.kind == "prismatic" for part in segments])
    return ArmTruth(
        name=name,
        urdf=text,
        tool=TOOL,
        links=links,
        rotor_inertia=rotor,
        torque_offset=load * rng.uniform(-0.03, 0.03, len(load)),
        friction=_friction(load, bounds["top_speed"], slides, rng),
        bandwidth=float(rng.uniform(*design.bandwidth)),
        lower=bounds["lower"],
        upper=bounds["upper"],
        top_speed=bounds["top_speed"],
        top_acceleration=bounds["top_acceleration"],
    )


def typical_load(text: str, links: Array, rotor: Array, bounds: dict[str, Array]) -> Array:
    """Root mean square torque (n,) [N m or N] of gravity and inertia over random states, at least 1.5 % of the largest."""
    model, data = rigid(text, links)
    rng = np.random.default_rng(402)
    torque = np.empty((POSES, len(rotor)))
    for row in torque:
        q = rng.uniform(bounds["lower"], bounds["upper"])
        v = rng.uniform(-0.6, 0.6, len(q)) * bounds["top_speed"]
        a = rng.uniform(-0.6, 0.6, len(q)) * bounds["top_acceleration"]
        row[:] = pin.rnea(model, data, q, v, a) + rotor * a
    load = np.sqrt(np.mean(torque**2, axis=0))
    return np.maximum(load, 0.015 * load.max())


def _bodies(text: str, flange: tuple[float, float, float], rng: np.random.Generator) -> Array:
    """True parameters (n, 10): each body deformed, and now and then an adapter at the flange."""
    links = np.array([deformed(row, 0.08, rng) for row in described(text)])
    if rng.random() < FORGOTTEN:
        mass = links[-1, 0] * rng.uniform(0.1, 0.35)
        links[-1] = with_lump(links[-1], mass, np.array(flange), 0.15 * float(np.linalg.norm(flange)))
    return links


def _bounds(segments: tuple[Segment, ...]) -> dict[str, Array]:
    columns = {"lower": "low", "upper": "high", "top_speed": "speed", "top_acceleration": "acceleration"}
    return {name: np.array([getattr(part, column) for part in segments]) for name, column in columns.items()}


def _rotors(text: str, links: Array, bounds: dict[str, Array], rng: np.random.Generator) -> Array:
    """Rotor inertia (n,) at the joint: less than the links' at the base, several times theirs at the wrist."""
    model, data = rigid(text, links)
    mass = pin.crba(model, data, 0.7 * bounds["lower"] + 0.3 * bounds["upper"])
    own = np.diag(mass)
    outward = np.linspace(0, 1, len(own))
    return own * np.exp(rng.uniform(np.log(0.15), np.log(0.6), len(own)) + 3.0 * outward)


def _friction(load: Array, top_speed: Array, slides: NDArray[np.bool_], rng: np.random.Generator) -> FrictionTruth:
    """Friction in proportion to what a joint is built for; lengths of a sliding joint are shorter than angles."""
    n = len(load)
    unit = np.where(slides, 0.2, 1.0)
    coulomb = load * rng.uniform(0.06, 0.35, n)
    deflection = unit * _between(3e-4, 8e-3, rng, n)  # of the bristles where the joint begins to slide
    fields: dict[str, Any] = {
        "coulomb": coulomb,
        "viscous": coulomb / top_speed * rng.uniform(0.2, 1.6, n),
        "breakaway": coulomb * (1 + rng.uniform(0, 0.5, n) * (rng.random(n) < 0.7)),
        "stribeck_speed": unit * _between(0.008, 0.15, rng, n),
        "bristle_stiffness": coulomb / deflection,
        # a bristle that is damped more than this could give energy back at top speed
        "bristle_damping": coulomb / top_speed * rng.uniform(0.2, 0.9, n),
        "width": unit * _between(5e-4, 5e-2, rng, n),
        "per_degree": rng.uniform(0.002, 0.009, n),
    }
    return FrictionTruth(kind=FRICTIONS[int(rng.integers(3))], **fields)


def _between(low: float, high: float, rng: np.random.Generator, n: int) -> Array:
    """Values (n,) whose logarithm is uniform."""
    return np.exp(rng.uniform(np.log(low), np.log(high), n))
