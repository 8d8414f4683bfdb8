"""An estimate: a model with what its identification knows about it, and the file it is kept in."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.errors import InputError
from physident.estimation.estimate_file import check_entries
from physident.estimation.estimators import Estimator, Physical, estimator_as_dict, estimator_from_dict
from physident.estimation.physical.certificate import Certificate
from physident.estimation.physical.cones import physical_cones
from physident.estimation.shape_errors import FoundShape
from physident.estimation.uncertainty import t_quantile
from physident.files import naming, read_json, write_json
from physident.identifiability.base_parameters import BaseParameters, find_base_parameters
from physident.recordings.columns import Columns
from physident.recordings.recording import check_gains
from physident.recordings.signals import Filter

Array = NDArray[np.float64]
SCHEMA = "physident.model/1"
MAX_BYTES = 200_000_000  # of a model file


@dataclass(frozen=True)
class Source:
    """A recording that was fitted: its path, the hash of its parsed arrays, its duration and the part used [s]."""

    path: str
    sha256: str
    duration: float
    used: float


@dataclass(frozen=True, eq=False)
class Estimate:
    """An identified model and how sure it is.

    ``covariance`` (r, r) of the base parameters, valid under autocorrelated residuals; ``sigma`` (n,) [N m|N] and
    ``relative`` (n,) [%] residual per joint on the fitted recordings; ``effective_samples`` (n,) what they are worth.
    ``filter``, ``columns`` and ``drive_gains`` are remembered for recordings to come. ``blocks`` are behind the
    covariance. A physical estimate says what decided it: ``shares`` (p,) of the information of independent directions
    that came from data, ``base_shares`` (r,) of each base parameter, ``held`` the cones it rests on.
    ``shapes`` are the shape parameters that were found, not given; their uncertainty is in ``covariance``.
    """

    model: Model
    estimator: Estimator
    covariance: Array
    sigma: Array
    relative: Array
    effective_samples: Array
    certificate: Certificate
    filter: Filter
    sources: tuple[Source, ...]
    columns: str | None = None
    drive_gains: tuple[float, ...] | None = None
    blocks: int = 2
    prior_weight: float | None = None
    shares: tuple[float, ...] = ()
    base_shares: tuple[float, ...] = ()
    held: tuple[str, ...] = ()
    shapes: tuple[FoundShape, ...] = ()

    @property
    def method(self) -> str:
        """Name of the estimator: ols, wls, robust or physical."""
        return self.estimator.name

    @property
    def theta(self) -> Array:
        """Parameters (p,) in the units of ``model.columns``."""
        return self.model.theta

    @cached_property
    def base(self) -> BaseParameters:
        """The base parameters of the model's robot and effects."""
        return find_base_parameters(self.model.robot, self.model.effects)

    @cached_property
    def standard_errors(self) -> Array:
        """Standard error (p,) of each parameter that torques show on its own; NaN for those they show only in sums."""
        result = np.full(len(self.theta), math.nan)
        alone = np.abs(self.base.beta).max(axis=1, initial=0.0) < 1e-9
        result[self.base.independent[alone]] = np.sqrt(np.diag(self.covariance))[alone]
        return result

    def intervals(self, level: float = 0.95) -> Array:
        """Lower and upper end (r, 2) of each base parameter's two-sided interval, by Student's t over the blocks.

        For a physical estimate they hold for the base parameters that the data decided, see ``base_shares``.
        """
        if not 0 < level < 1:
            raise InputError(f"level is {level}, expected a probability between 0 and 1, such as 0.95")
        half = t_quantile(self.blocks, level) * np.sqrt(np.diag(self.covariance))
        values = self.base.values(self.theta)
        return np.column_stack([values - half, values + half])

    @cached_property
    def violations(self) -> tuple[str, ...]:
        """What no real arm could be about these parameters, in words; empty where they are physical."""
        return tuple(physical_cones(self.model.robot, self.model.effects).broken(self.theta))

    def save(self, path: str | Path) -> None:
        """Write the estimate as JSON (schema physident.model/1), whole or not at all."""
        write_json(path, self.as_dict())

    def as_dict(self) -> dict[str, Any]:
        """Everything the estimate holds, as JSON can hold it."""
        return {
            "schema": SCHEMA,
            **self.model.as_dict(),
            "estimator": estimator_as_dict(self.estimator),
            "prior_weight": self.prior_weight,
            "blocks": self.blocks,
            "shares": list(self.shares),
            "base_shares": list(self.base_shares),
            "held": list(self.held),
            "shapes": [vars(shape) for shape in self.shapes],
            "violations": list(self.violations),
            "base_parameters": [
                {"expression": text, "value": float(value), "std": float(std)}
                for text, value, std in zip(
                    self.base.expressions(),
                    self.base.values(self.theta),
                    np.sqrt(np.diag(self.covariance)),
                    strict=True,
                )
            ],
            "covariance": self.covariance.tolist(),
            "sigma": self.sigma.tolist(),
            "relative_percent": self.relative.tolist(),
            "effective_samples": self.effective_samples.tolist(),
            "certificate": vars(self.certificate),
            "filter": vars(self.filter),
            "columns": self.columns,
            "drive_gains": self.drive_gains and list(self.drive_gains),
            "recordings": [vars(source) for source in self.sources],
        }

    def __repr__(self) -> str:
        from physident.estimation.estimate_text import estimate_text

        return estimate_text(self)


def load_estimate(path: str | Path) -> Estimate:
    """The estimate in a model file; raises InputError where it is missing, no JSON, or of another schema."""
    data = read_json(path, MAX_BYTES, "a model file that identify wrote", SCHEMA)
    with naming(path, "model", "identify it again"):
        return _from_dict(data)


def _from_dict(data: dict[str, Any]) -> Estimate:
    check_entries(data)
    estimate = Estimate(
        model=Model.from_dict(data),
        estimator=estimator_from_dict(data["estimator"]),
        covariance=np.array(data["covariance"], dtype=float),
        sigma=np.array(data["sigma"], dtype=float),
        relative=np.array(data["relative_percent"], dtype=float),
        effective_samples=np.array(data["effective_samples"], dtype=float),
        certificate=Certificate(**data["certificate"] | {"eigenvalues": tuple(data["certificate"]["eigenvalues"])}),
        filter=Filter(**data["filter"]),
        sources=tuple(Source(**source) for source in data["recordings"]),
        columns=data["columns"],
        drive_gains=data["drive_gains"] and tuple(data["drive_gains"]),
        blocks=data["blocks"],
        prior_weight=data["prior_weight"],
        shares=tuple(data["shares"]),
        base_shares=tuple(data["base_shares"]),
        held=tuple(data["held"]),
        shapes=tuple(FoundShape(**shape) for shape in data["shapes"]),
    )
    _check(estimate)
    return estimate


def _check(estimate: Estimate) -> None:
    """Raises InputError where the parts of an estimate do not fit one another, as in a file edited by hand."""
    n, r = estimate.model.robot.n, estimate.base.r
    shapes = {"covariance": (r, r), "sigma": (n,), "relative": (n,), "effective_samples": (n,)}
    for name, shape in shapes.items():
        value = getattr(estimate, name)
        if (
            value.shape != shape
            or not np.isfinite(value).all()
            or (np.diag(value) if name == "covariance" else value).min() < 0
        ):
            raise InputError(f"{name} does not fit: expected {shape} finite numbers, not negative; identify it again")
    _check_physical(estimate, r)
    _check_shapes(estimate)
    if estimate.columns is not None:
        Columns.parse(estimate.columns)
    if estimate.drive_gains is not None:
        check_gains(estimate.drive_gains, n, "the model")


def _check_physical(estimate: Estimate, r: int) -> None:
    """What decided a physical estimate says it of every base parameter; another estimate has no prior."""
    if len(estimate.base_shares) not in ((r,) if estimate.shares else (0, r)):
        raise InputError(f"base_shares holds {len(estimate.base_shares)} numbers, expected {r}; identify it again")
    if not isinstance(estimate.estimator, Physical) and (estimate.prior_weight is not None or estimate.shares):
        raise InputError(
            f"prior_weight or shares stand beside {estimate.method}, which has no prior; identify it again"
        )


def _check_shapes(estimate: Estimate) -> None:
    known = {(effect.name, shape.field) for effect in estimate.model.effects for shape in effect.shape_parameters}
    for found in estimate.shapes:
        if (found.effect, found.field) not in known or not found.joint <= estimate.model.robot.n:
            raise InputError(
                f"shapes: the model has no {found.field} of {found.effect} on joint {found.joint}; identify it again"
            )
