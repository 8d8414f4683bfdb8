"""The identified parameters as JSON: values, units, intervals, and every link as a body with a centre of mass."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from physident.estimation.estimate import Estimate
from physident.estimation.uncertainty import t_quantile
from physident.files import write_json
from physident.robots.inertia import about_centre, violations

SCHEMA = "physident.parameters/1"


def export_parameters(estimate: Estimate, path: str | Path) -> None:
    """Write an estimate's parameters with units and 95 % intervals as JSON; raises InputError where it cannot."""
    write_json(path, parameters_of(estimate))


def parameters_of(estimate: Estimate) -> dict[str, Any]:
    """Parameters, base parameters, links, drive gains and recordings, as JSON can hold them.

    ``interval`` is the 95 % confidence interval [low, high]. It is null for a parameter that torques determine only as
    part of a sum; that sum is one of the ``base_parameters``, with an interval. In a physical estimate
    ``share_from_data`` is the share of a base parameter that the recordings decided, not the prior.
    """
    model = estimate.model
    return {
        "schema": SCHEMA,
        "robot": model.robot.name,
        "joints": list(model.robot.joint_names),
        "method": estimate.method,
        "gravity_m_s2": list(model.robot.gravity),
        "parameters": _parameters(estimate),
        "base_parameters": _base_parameters(estimate),
        "links": _links(estimate),
        "drive_gains_Nm_A": estimate.drive_gains and list(estimate.drive_gains),
        "cutoff_Hz": estimate.filter.cutoff,
        "recordings": [{"path": source.path, "sha256": source.sha256} for source in estimate.sources],
    }


def _parameters(estimate: Estimate) -> list[dict[str, Any]]:
    half = t_quantile(estimate.blocks)
    return [
        {"name": c.name, "effect": c.effect, "joint": c.joint, "unit": c.unit, **_uncertain(value, std, half)}
        for c, value, std in zip(estimate.model.columns, estimate.theta, estimate.standard_errors, strict=True)
    ]


def _base_parameters(estimate: Estimate) -> list[dict[str, Any]]:
    base = estimate.base
    units = [base.columns[i].unit for i in base.independent]
    errors = np.sqrt(np.diag(estimate.covariance))
    half = t_quantile(estimate.blocks)
    rows = [
        {"expression": text, "unit": unit, **_uncertain(value, std, half)}
        for text, unit, value, std in zip(base.expressions(), units, base.values(estimate.theta), errors, strict=True)
    ]
    for row, share in zip(rows, estimate.base_shares, strict=False):
        row["share_from_data"] = float(share)
    return rows


def _uncertain(value: float, std: float, half: float) -> dict[str, Any]:
    """Value, standard error and the interval of ``half`` standard errors on either side."""
    known = bool(np.isfinite(std))
    interval = [float(value - half * std), float(value + half * std)] if known else None
    return {"value": float(value), "std": float(std) if known else None, "interval": interval}


def _links(estimate: Estimate) -> list[dict[str, Any]]:
    """Each link's mass, centre of mass and inertia about it, in its joint's frame; null where its mass is not positive."""
    links = []
    for number, phi in enumerate(estimate.model.added_inertia().links.reshape(-1, 10), 1):
        centre, inertia = about_centre(phi) if phi[0] > 0 else (None, None)
        links.append(
            {
                "link": number,
                "mass_kg": float(phi[0]),
                "centre_of_mass_m": None if centre is None else centre.tolist(),
                "inertia_about_centre_kg_m2": None if inertia is None else inertia.tolist(),
                "not_physical": violations(phi),
            }
        )
    return links
