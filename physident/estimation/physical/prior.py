"""Priors: how far a robot's nominal values are trusted beside the recordings."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Column
from physident.errors import InputError, did_you_mean, warn
from physident.json_records import RecordReader
from physident.robots.inertia import link_parameters, pseudo_inertia

Array = NDArray[np.float64]
TIE_BREAK = 1e-6  # weight of the distance to nominal for parameters that neither data nor prior determine
TIE_BREAK_OTHERS = 1e-8  # for other parameters than links, in SI units: any real recording determines them
THINNEST = 0.01  # m: radius of gyration below which no link of an arm is built
LIGHTEST = 0.01  # kg: for a link whose description states no mass


@dataclass(frozen=True)
class Prior(ABC):
    """How far nominal values are trusted.

    A weight of one says that a link's pseudo-inertia is known to a factor of about e (one standard deviation) along
    every direction, a weight of 100 to about a tenth of itself; "auto" chooses it by left-out recordings. ``nominal``
    (p,) in the order of the model's columns replaces the robot's own description.
    """

    weight: float | Literal["auto"] = 1.0
    nominal: tuple[float, ...] | None = None

    name: ClassVar[str]

    def __post_init__(self) -> None:
        number = isinstance(self.weight, int | float) and math.isfinite(self.weight) and self.weight > 0
        if not number and self.weight != "auto":
            raise InputError(f"prior weight is {self.weight!r}, expected a positive number or 'auto'")
        if self.nominal is not None:
            object.__setattr__(self, "nominal", tuple(float(x) for x in self.nominal))

    def as_dict(self) -> dict[str, Any]:
        """Its name and settings as plain numbers and texts for JSON."""
        return {"prior": self.name, "weight": self.weight, "nominal": self.nominal and list(self.nominal)}


@dataclass(frozen=True)
class NoPrior(Prior):
    """Nominal values only break ties between parameters that torques cannot distinguish."""

    weight: float | Literal["auto"] = TIE_BREAK

    name: ClassVar[str] = "none"

    def __post_init__(self) -> None:
        if self.weight != TIE_BREAK:
            raise InputError(f"prior none has no weight, got {self.weight!r}; use nominal or entropic")
        super().__post_init__()


@dataclass(frozen=True)
class NominalDistance(Prior):
    """weight / 2 * |X - 1|^2 for each link, X = P0^-1/2 P P0^-1/2 its pseudo-inertia P whitened by the nominal P0."""

    name: ClassVar[str] = "nominal"


@dataclass(frozen=True)
class Entropic(Prior):
    """weight * (tr X - log det X - 4) for each link, X = P0^-1/2 P P0^-1/2: the divergence of two Gaussian mass clouds.

    Source: Lee, Wensing, Park, "Geometric robot dynamic identification: a convex programming approach" (2020), eq. 24;
    near the nominal it equals ``NominalDistance`` of the same weight.
    """

    name: ClassVar[str] = "entropic"


READER = RecordReader("identify it again")
PRIORS: dict[str, type[Prior]] = {prior.name: prior for prior in (NoPrior, NominalDistance, Entropic)}


def make_prior(name: str, weight: float | Literal["auto"] | None = None) -> Prior:
    """The prior of a name, with its default weight where none is given; raises InputError for another name."""
    kind = _prior_class(name)
    return kind() if weight is None else kind(weight)


def prior_from_dict(data: dict[str, Any]) -> Prior:
    """The prior that ``Prior.as_dict`` described; raises InputError, naming the entry, for a wrong value."""
    kind = _prior_class(READER.read(str, data["prior"], "estimator.prior.prior"))
    weight = READER.read(float | Literal["auto"], data["weight"], "estimator.prior.weight")
    return kind(weight, READER.read(tuple[float, ...] | None, data["nominal"], "estimator.prior.nominal"))


def _prior_class(name: str) -> type[Prior]:
    if name not in PRIORS:
        raise InputError(f"prior {name!r} is unknown, expected one of {', '.join(PRIORS)}{did_you_mean(name, PRIORS)}")
    return PRIORS[name]


def nominal_values(prior: Prior, columns: Sequence[Column], described: Array) -> Array:
    """Nominal parameters (p,): the prior's own, else ``described``; raises InputError for a wrong length or a NaN."""
    if prior.nominal is None:
        return described
    values = np.array(prior.nominal)
    if len(values) != len(columns):
        first, last = columns[0].name, columns[-1].name
        raise InputError(f"prior has {len(values)} nominal values, expected {len(columns)}: {first} to {last}")
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        names = ", ".join(columns[i].name for i in bad[:5])
        raise InputError(f"prior is {values[bad[0]]} for {names}; expected finite nominal values such as the robot's")
    return values


def solid_link(phi: Array, link: str) -> Array:
    """Ten nominal parameters (10,) of a link with mass and extent, as a prior on its pseudo-inertia needs.

    The nearest ones with the same mass and centre of mass: radii of gyration below 1 cm are raised to it, with a
    PhysidentWarning that names the link; a link without mass is given 10 g there.
    """
    m = max(float(phi[0]), LIGHTEST)
    c = phi[1:4] / m if phi[0] > 0 else np.zeros(3)
    spread = pseudo_inertia(phi)[:3, :3] / m - np.outer(c, c)
    values, vectors = np.linalg.eigh(spread)
    if phi[0] >= LIGHTEST and values[0] > 0:
        return phi
    spread = (vectors * np.maximum(values, THINNEST**2)) @ vectors.T
    P = np.zeros((4, 4))
    P[:3, :3], P[:3, 3], P[3, :3], P[3, 3] = m * (spread + np.outer(c, c)), m * c, m * c, m
    warn(
        f"{link}: nominal inertia is not that of a solid body (mass {phi[0]:.4g} kg, smallest squared radius of gyration"
        f" {values[0]:.2g} m^2); the prior uses the nearest one that is"
    )
    return link_parameters(P)
