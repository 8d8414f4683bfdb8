"""The record of an identification: the model, its uncertainty, and the settings and recordings behind it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.errors import InputError
from physident.estimation.estimators import Estimator
from physident.estimation.physical.certificate import Certificate
from physident.estimation.physical.cones import physical_cones
from physident.estimation.shapes.shape_uncertainty import FoundShape
from physident.estimation.uncertainty import t_quantile
from physident.identifiability.base_parameters import BaseParameters, find_base_parameters
from physident.json_records import NotNegative
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Source:
    """A fitted recording: its path, the hash of its parsed arrays, its duration [s] and the part of it that was used [s]."""

    path: str
    sha256: str
    duration: NotNegative
    used: NotNegative


@dataclass(frozen=True, eq=False, kw_only=True)
class EstimatedModel:
    """An identified model and its uncertainty.

    ``covariance`` (r, r) of the base parameters, valid for autocorrelated residuals, from a jackknife over ``blocks``
    blocks; ``sigma`` (n,) [N m|N] and ``relative`` (n,) [%] of all fitted rows, as ``validate`` scores them;
    ``effective_samples`` (n,) number of independent samples they are worth; ``information`` (r, r) about the base parameters in
    the fitted rows at that worth, where it is known. ``filter``, ``layout`` (the columns of the
    recordings' files) and ``drive_gains`` are the defaults for other recordings. ``fitted`` are the recordings
    themselves, which a file does not hold.

    A physical estimate also states what determined it: ``shares`` (p,) of the information in independent directions
    that came from the data, ``base_shares`` (r,) the same for each base parameter, and ``active_constraints``, the
    constraints that the solution rests on. ``shape_parameters`` are those that were identified rather than given; their
    uncertainty is included in ``covariance``. ``unsized`` are the names of base parameters whose torques would be many times
    the measured one and cancel one another; ``warnings`` state what is wrong with the recordings' set-up. ``path`` is that of
    the file that it was read from.
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
    fitted: tuple[Recording, ...] = ()
    layout: str | None = None
    drive_gains: tuple[float, ...] | None = None
    blocks: int = 2
    information: Array | None = None
    prior_weight: float | None = None
    shares: tuple[float, ...] = ()
    base_shares: tuple[float, ...] = ()
    active_constraints: tuple[str, ...] = ()
    shape_parameters: tuple[FoundShape, ...] = ()
    unsized: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    path: str | None = None

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
        """Standard error (p,) of each parameter; NaN for a parameter that can be identified only in a sum with others."""
        result = np.full(len(self.theta), math.nan)
        alone = np.abs(self.base.beta).max(axis=1, initial=0.0) < 1e-9
        result[self.base.independent[alone]] = np.sqrt(np.diag(self.covariance))[alone]
        return result

    def intervals(self, level: float = 0.95) -> Array:
        """Lower and upper end (r, 2) of each base parameter's two-sided interval, by Student's t over the blocks.

        For a physical estimate they are valid for the base parameters that the data determine, see ``base_shares``.
        Raises InputError for a level that is no probability.
        """
        if not 0 < level < 1:
            raise InputError(f"level is {level}, expected a probability between 0 and 1, such as 0.95")
        half = t_quantile(self.blocks, level) * np.sqrt(np.diag(self.covariance))
        values = self.base.values(self.theta)
        return np.column_stack([values - half, values + half])

    @cached_property
    def violations(self) -> tuple[str, ...]:
        """The physical constraints that the parameters violate, in words; empty where they are physical."""
        return tuple(physical_cones(self.model.robot, self.model.effects).broken(self.theta))
