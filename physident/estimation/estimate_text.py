"""An estimate as text on one screen: values, units, how sure, and what the data could not decide."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from physident.effects.catalogue import CATALOGUE
from physident.estimation.estimators import Physical
from physident.estimation.physical.decision import BY_DATA, BY_PRIOR

if TYPE_CHECKING:
    from physident.estimation.estimate import Estimate

WIDTH = 100  # characters of a line
EDGE = 1.02  # a shape this close to the end of its grid was stopped by it
LISTED = 12  # parameters listed one by one
VAGUE = 0.5  # a base parameter whose standard error exceeds this share of its value is called vague


def estimate_text(estimate: Estimate) -> str:
    """The printed form of an estimate."""
    model, base, certificate = estimate.model, estimate.base, estimate.certificate
    used = sum(source.used for source in estimate.sources)
    values, std = base.values(model.theta), np.sqrt(np.diag(estimate.covariance))
    vague = np.flatnonzero(std > VAGUE * np.abs(values))
    prior = "" if estimate.prior_weight is None else _prior(estimate)
    rows = [
        f"Estimate of {model.robot.name} by {estimate.method}{prior}: {counted(len(estimate.sources))}, {used:.0f} s in motion,"
        f" cutoff {estimate.filter.cutoff:g} Hz",
        f"{base.r} base parameters of {len(model.columns)}; the data decide {certificate.determined};"
        f" condition {certificate.condition:.3g}",
        "",
        *_joint_table(estimate),
        "",
        "sigma: what is left of the torque; worth: how many independent samples that is, after its memory",
        f"largest gradient left {certificate.stationarity:.1e} (0 is exact)" + _proof(estimate),
    ]
    if estimate.shares:
        rows.append(_decided(estimate))
    if len(vague):
        worst = vague[np.argsort(-(std / np.maximum(np.abs(values), 1e-12))[vague])]
        names = ", ".join(base.columns[base.independent[i]].name for i in worst[:6])
        more = f" and {len(vague) - 6} more" if len(vague) > 6 else ""
        rows.append(f"vague (standard error above half the value): {names}{more}")
    broken = "; ".join(estimate.violations[:3]) + ("; ..." if len(estimate.violations) > 3 else "")
    rows.append(
        f"verdict: not physical: {broken}\n  (torques fix sums of parameters only: --method physical finds an arm that can exist)"
        if broken
        else "verdict: physical: every link is a rigid body, friction dissipates"
    )
    return "\n".join(rows)


def counted(recordings: int) -> str:
    """A number of recordings in words."""
    return "1 recording" if recordings == 1 else f"{recordings} recordings"


def _prior(estimate: Estimate) -> str:
    assert isinstance(estimate.estimator, Physical)
    prior = estimate.estimator.prior
    if prior.name == "none":
        return ", no prior"
    chosen = " chosen on left-out recordings" if prior.weight == "auto" else ""
    return f", {prior.name} prior of weight {estimate.prior_weight:g}{chosen}"


def _proof(estimate: Estimate) -> str:
    certificate = estimate.certificate
    if not estimate.shares:
        return ""
    least = min(certificate.eigenvalues, default=0.0)
    return f", cones violated by {certificate.primal:.1e}, gap {certificate.gap:.1e}; smallest share of a link's pseudo-inertia {least:.1e}"


def _decided(estimate: Estimate) -> str:
    shares = np.array(estimate.shares)
    data, prior = np.count_nonzero(shares >= BY_DATA), np.count_nonzero(shares <= BY_PRIOR)
    text = f"of {len(shares)} directions the data decided {data}, the prior {prior}, both {len(shares) - data - prior}"
    leaning = [
        estimate.base.columns[i].name
        for i, s in zip(estimate.base.independent, estimate.base_shares, strict=True)
        if s < BY_DATA
    ]
    if leaning:
        more = f" and {len(leaning) - 8} more" if len(leaning) > 8 else ""
        text += f"\nbase parameters that lean on the prior: {', '.join(leaning[:8])}{more}"
    return text + (f"\nheld by a bound: {'; '.join(f'else {h}' for h in estimate.held)}" if estimate.held else "")


def _joint_table(estimate: Estimate) -> list[str]:
    """A row a joint; effects with one parameter a joint are columns, side by side as far as the width goes."""
    model = estimate.model
    counts = Counter((c.effect, c.joint) for c in model.columns)
    effects = [e for e in dict.fromkeys(c.effect for c in model.columns) if e != "rigid_body"]
    single = [e for e in effects if all(count == 1 for (name, _), count in counts.items() if name == e)]
    units = {c.effect: c.unit for c in model.columns}
    errors = estimate.standard_errors
    head, unit = ("joint", "error %", "sigma", "worth"), ("", "", "[N m]", "")
    first = [f"{a:>5}  {b:>7}  {c:>9}  {d:>5}" for a, b, c, d in (head, unit)]
    first += [
        f"{j + 1:5d}  {estimate.relative[j]:7.2f}  {estimate.sigma[j]:9.4g}  {estimate.effective_samples[j]:5.0f}"
        for j in range(model.robot.n)
    ]
    blocks = [first]
    for effect in single:
        cells = [_cell(estimate, errors, effect, j + 1) for j in range(model.robot.n)]
        width = max(len(text) for text in (effect, *cells)) + 2
        column = [text.rjust(width) for text in (effect, f"[{units[effect]}]", *cells)]
        if len(blocks[-1][0]) + width > WIDTH:
            blocks.append(["joint", "     ", *(f"{j + 1:5d}" for j in range(model.robot.n))])
        blocks[-1] = [row + more for row, more in zip(blocks[-1], column, strict=True)]
    rows = [row.rstrip() for block in blocks for row in (*block, "")][:-1]
    others = [i for i, c in enumerate(model.columns) if c.effect in effects and c.effect not in single]
    for i in others[:LISTED]:
        c = model.columns[i]
        rows.append(f"{c.name} = {_value(estimate.theta[i], errors[i])} {c.unit}")
    if len(others) > LISTED:
        rows.append(f"and {len(others) - LISTED} more values in the model file")
    for f in estimate.shapes:
        text = f"{f.effect}, joint {f.joint}: {f.field} {f.value:.4g} ± {f.std:.2g} {f.unit}".removesuffix(" 1")
        (grid,) = [shape.grid for shape in CATALOGUE[f.effect].shape_parameters if shape.field == f.field]
        rows.append(text + ("" if EDGE * grid[0] < f.value < grid[-1] / EDGE else ", at the edge of its search"))
    return rows


def _cell(estimate: Estimate, errors: np.ndarray, effect: str, joint: int) -> str:
    found = [i for i, c in enumerate(estimate.model.columns) if c.effect == effect and c.joint == joint]
    return _value(estimate.theta[found[0]], errors[found[0]]) if found else "-"


def _value(value: float, std: float) -> str:
    return f"{value:.4g} (in a sum)" if np.isnan(std) else f"{value:.4g} ± {std:.2g}"
