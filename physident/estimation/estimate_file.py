"""Model files: the estimate that ``Estimate.save`` wrote, read back and checked entry by entry."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from physident.dynamics.model_entries import read_model
from physident.errors import InputError
from physident.estimation.estimate import SCHEMA, Estimate
from physident.estimation.estimated_model import Source
from physident.estimation.estimators import Physical, estimator_from_dict
from physident.estimation.physical.certificate import Certificate
from physident.estimation.shapes.shape_uncertainty import FoundShape
from physident.files import naming, read_json
from physident.json_records import NotNegative, Positive, RecordReader, Share
from physident.recordings.channels import check_gains
from physident.recordings.columns.reading import Reading
from physident.recordings.signals import Filter

REMEDY = "identify it again"
READER = RecordReader(REMEDY)
MAX_BYTES = 200_000_000  # of a model file


@dataclass(frozen=True, kw_only=True)
class _Entries:
    """The entries of a model file beside robot, effects and parameters, which ``Model`` reads."""

    estimator: dict
    covariance: tuple[tuple[float, ...], ...]
    information: tuple[tuple[float, ...], ...] | None
    sigma: tuple[NotNegative, ...]
    relative_percent: tuple[NotNegative, ...]
    effective_samples: tuple[NotNegative, ...]
    certificate: Certificate
    filter: Filter
    recordings: tuple[Source, ...]
    columns: str | None
    drive_gains: tuple[float, ...] | None
    blocks: Positive
    prior_weight: NotNegative | None
    shares: tuple[Share, ...]
    base_shares: tuple[Share, ...]
    held: tuple[str, ...]
    shapes: tuple[FoundShape, ...]
    unsized: tuple[str, ...]
    warnings: tuple[str, ...]


def load_estimate(path: str | Path) -> Estimate:
    """The estimate in a model file; raises InputError where the file is missing, no JSON, of another schema, or damaged."""
    data = read_json(path, MAX_BYTES, "a model file that identify wrote", SCHEMA)
    with naming(path, "model", REMEDY):
        return replace(_from_dict(data), path=str(path))


def _from_dict(data: dict[str, Any]) -> Estimate:
    entries = READER.read(
        _Entries, {"unsized": [], "warnings": [], "information": None} | data, ""
    )  # older files lack them
    estimate = Estimate(
        model=read_model(data, READER),
        estimator=estimator_from_dict(entries.estimator),
        covariance=np.array(entries.covariance),
        information=None if entries.information is None else np.array(entries.information),
        sigma=np.array(entries.sigma),
        relative=np.array(entries.relative_percent),
        effective_samples=np.array(entries.effective_samples),
        certificate=entries.certificate,
        filter=entries.filter,
        sources=entries.recordings,
        layout=entries.columns,
        drive_gains=entries.drive_gains,
        blocks=entries.blocks,
        prior_weight=entries.prior_weight,
        shares=entries.shares,
        base_shares=entries.base_shares,
        active_constraints=entries.held,
        shape_parameters=entries.shapes,
        unsized=entries.unsized,
        warnings=entries.warnings,
    )
    _check_sizes(estimate)
    _check_shares(estimate)
    _check_shape_parameters(estimate)
    if estimate.layout is not None:
        Reading.parse(estimate.layout)
    if estimate.drive_gains is not None:
        check_gains(estimate.drive_gains, estimate.model.robot.n, "the model")
    return estimate


def _check_sizes(estimate: Estimate) -> None:
    n, r = estimate.model.robot.n, estimate.base.r
    sizes = {"covariance": (r, r), "sigma": (n,), "relative": (n,), "effective_samples": (n,)}
    if estimate.information is not None:
        sizes["information"] = (r, r)
    for name, size in sizes.items():
        if (found := getattr(estimate, name).shape) != size:
            raise InputError(f"{name} has shape {found}, expected {size}; {REMEDY}")
    if (variances := np.diag(estimate.covariance)).min() < 0:
        raise InputError(f"covariance has a variance of {variances.min():g}, expected none below zero; {REMEDY}")


def _check_shares(estimate: Estimate) -> None:
    """A physical estimate has a share for every base parameter; any other has no prior, and need not have shares."""
    r = estimate.base.r
    if len(estimate.base_shares) not in ((r,) if estimate.shares else (0, r)):
        raise InputError(f"base_shares has {len(estimate.base_shares)} numbers, expected {r}; {REMEDY}")
    if not isinstance(estimate.estimator, Physical) and (estimate.prior_weight is not None or estimate.shares):
        raise InputError(f"prior_weight or shares are given for method {estimate.method}, which has no prior; {REMEDY}")


def _check_shape_parameters(estimate: Estimate) -> None:
    known = {(effect.name, shape.field) for effect in estimate.model.effects for shape in effect.shape_parameters}
    for found in estimate.shape_parameters:
        if (found.effect, found.field) not in known or found.joint > estimate.model.robot.n:
            raise InputError(
                f"shapes: the model has no {found.field} of {found.effect} on joint {found.joint}; {REMEDY}"
            )
