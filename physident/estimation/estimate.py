"""An estimate: a model with what its identification knows about it, and the file it is kept in."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.base_parameters import BaseParameters, find_base_parameters
from physident.errors import InputError
from physident.files import write_text
from physident.model import Model
from physident.signals import Filter

Array = NDArray[np.float64]
SCHEMA = "physident.model/1"


@dataclass(frozen=True)
class Source:
    """A recording that was fitted: its path, the hash of its parsed arrays, its duration and the part used [s]."""

    path: str
    sha256: str
    duration: float
    used: float


@dataclass(frozen=True)
class Certificate:
    """What the estimator proves about its answer: largest normalised gradient left, condition number of the scaled
    regressor, how many of the base parameters the data decided, iterations."""

    stationarity: float
    condition: float
    determined: int
    iterations: int


@dataclass(frozen=True, eq=False)
class Estimate:
    """An identified model and how sure it is.

    ``covariance`` (r, r) of the base parameters, valid under autocorrelated residuals; ``sigma`` (n,) [N m|N] and
    ``relative`` (n,) [%] residual per joint on the fitted recordings; ``effective_samples`` (n,) what they are worth.
    ``filter``, ``columns`` and ``drive_gains`` are remembered for recordings to come.
    """

    model: Model
    method: str
    covariance: Array
    sigma: Array
    relative: Array
    effective_samples: Array
    certificate: Certificate
    filter: Filter
    sources: tuple[Source, ...]
    columns: str | None = None
    drive_gains: tuple[float, ...] | None = None

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

    def save(self, path: str | Path) -> None:
        """Write the estimate as JSON (schema physident.model/1), whole or not at all."""
        write_text(path, json.dumps(self.as_dict(), indent=1, allow_nan=False) + "\n")

    def as_dict(self) -> dict[str, Any]:
        """Everything the estimate holds, as JSON can hold it."""
        return {
            "schema": SCHEMA,
            **self.model.as_dict(),
            "method": self.method,
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
        from physident.estimation.printing import estimate_text

        return estimate_text(self)


def load_estimate(path: str | Path) -> Estimate:
    """The estimate in a model file; raises InputError where it is missing, no JSON, or of another schema."""
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not text"
        raise InputError(
            f"model {str(path)!r} cannot be read ({reason}); expected a file that identify wrote"
        ) from None
    except (json.JSONDecodeError, RecursionError) as error:
        raise InputError(f"{path}: not valid JSON ({error}); expected a file that identify wrote") from None
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        found = data.get("schema") if isinstance(data, dict) else type(data).__name__
        raise InputError(f"{path}: schema is {found!r}, expected {SCHEMA!r}: a file that identify wrote")
    try:
        return _from_dict(data)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"{path}: not a complete model ({type(error).__name__}: {error}); identify it again") from None


def _from_dict(data: dict[str, Any]) -> Estimate:
    estimate = Estimate(
        model=Model.from_dict(data),
        method=data["method"],
        covariance=np.array(data["covariance"], dtype=float),
        sigma=np.array(data["sigma"], dtype=float),
        relative=np.array(data["relative_percent"], dtype=float),
        effective_samples=np.array(data["effective_samples"], dtype=float),
        certificate=Certificate(**data["certificate"]),
        filter=Filter(**data["filter"]),
        sources=tuple(Source(**source) for source in data["recordings"]),
        columns=data["columns"],
        drive_gains=data["drive_gains"] and tuple(data["drive_gains"]),
    )
    n, r = estimate.model.robot.n, estimate.base.r
    if estimate.sigma.shape != (n,) or estimate.covariance.shape != (r, r):
        raise ValueError(
            f"sigma {estimate.sigma.shape} and covariance {estimate.covariance.shape} do not fit {n} joints"
        )
    return estimate
