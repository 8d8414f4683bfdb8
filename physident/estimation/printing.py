"""An estimate as text on one screen: values, units, how sure, and what the data could not decide."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from physident.estimation.estimate import Estimate

VAGUE = 0.5  # a base parameter whose standard error exceeds this share of its value is called vague


def estimate_text(estimate: Estimate) -> str:
    """The printed form of an estimate."""
    model, base, certificate = estimate.model, estimate.base, estimate.certificate
    used = sum(source.used for source in estimate.sources)
    values, std = base.values(model.theta), np.sqrt(np.diag(estimate.covariance))
    vague = np.flatnonzero(std > VAGUE * np.abs(values))
    rows = [
        f"Estimate of {model.robot.name} by {estimate.method}: {len(estimate.sources)} recordings, {used:.0f} s in motion,"
        f" cutoff {estimate.filter.cutoff:g} Hz",
        f"{base.r} base parameters of {len(model.columns)}; the data decide {certificate.determined};"
        f" condition {certificate.condition:.3g}",
        "",
        *_joint_table(estimate),
        "",
        f"largest gradient left {certificate.stationarity:.1e} (0 is exact)",
    ]
    if len(vague):
        worst = vague[np.argsort(-(std / np.maximum(np.abs(values), 1e-12))[vague])]
        names = ", ".join(base.columns[base.independent[i]].name for i in worst[:6])
        more = f" and {len(vague) - 6} more" if len(vague) > 6 else ""
        rows.append(f"vague (standard error above half the value): {names}{more}")
    return "\n".join(rows)


def _joint_table(estimate: Estimate) -> list[str]:
    model = estimate.model
    effects = [e for e in dict.fromkeys(c.effect for c in model.columns) if e != "rigid_body"]
    units = {c.effect: c.unit for c in model.columns}
    heads = [f"{effect.replace('_', ' ')} [{units[effect]}]" for effect in effects]
    widths = [max(19, len(head)) for head in heads]
    rows = ["joint  error %  sigma [N m]  worth  " + "  ".join(h.rjust(w) for h, w in zip(heads, widths, strict=True))]
    errors = estimate.standard_errors
    for j in range(model.robot.n):
        cells = [_cell(estimate, errors, effect, j + 1) for effect in effects]
        rows.append(
            f"{j + 1:5d}  {estimate.relative[j]:7.2f}  {estimate.sigma[j]:11.4g}  {estimate.effective_samples[j]:5.0f}  "
            + "  ".join(c.rjust(w) for c, w in zip(cells, widths, strict=True))
        )
    return rows


def _cell(estimate: Estimate, errors: np.ndarray, effect: str, joint: int) -> str:
    found = [i for i, c in enumerate(estimate.model.columns) if c.effect == effect and c.joint == joint]
    if len(found) != 1:
        return f"{len(found)} values" if found else "-"
    value, std = estimate.theta[found[0]], errors[found[0]]
    return f"{value:.4g} (in a sum)" if np.isnan(std) else f"{value:.4g} ± {std:.2g}"
