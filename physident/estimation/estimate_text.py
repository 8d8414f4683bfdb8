"""The printed form of an estimate on one screen: values, units, uncertainty, and what the data could not determine."""

from __future__ import annotations

from collections import Counter

import numpy as np

from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import units_in_words
from physident.effects.learned.curve import LearnedCurve
from physident.estimation.estimated_model import EstimatedModel
from physident.estimation.estimators import Physical
from physident.estimation.physical.information_shares import BY_DATA, BY_PRIOR
from physident.estimation.sizing import UNSIZED
from physident.recordings.recording import recording_count

WIDTH = 100  # characters of a line
EDGE = 1.02  # a shape parameter within this factor of an end of its grid was limited by the grid
MAX_LISTED = 12  # parameters listed one by one
MAX_NAMES = 6  # vague base parameters named
POOR = 30.0  # %: a model that leaves more of a joint's torque predicts it no better than friction alone would
VAGUE = 0.5  # a base parameter whose standard error exceeds this share of its value is called vague


def estimate_text(estimate: EstimatedModel) -> str:
    """The printed form of an estimate."""
    model, base, certificate = estimate.model, estimate.base, estimate.certificate
    used = sum(source.used for source in estimate.sources)
    values, std = base.values(model.theta), np.sqrt(np.diag(estimate.covariance))
    curves = {effect.name for effect in model.effects if isinstance(effect, LearnedCurve)}
    of_curves = np.array([base.columns[i].effect in curves for i in base.independent], dtype=bool)
    vague = np.flatnonzero((std > VAGUE * np.abs(values)) & ~of_curves)
    prior = "" if estimate.prior_weight is None else _prior(estimate)
    rows = [
        f"Estimate of {model.robot.name} by {estimate.method}{prior}: {recording_count(len(estimate.sources))}, {used:.0f} s in motion,"
        f" cutoff {estimate.filter.cutoff:g} Hz",
        f"{base.r} base parameters of {len(model.columns)}; the data determine {certificate.determined};"
        f" condition {certificate.condition:.3g}",
        "",
        *_joint_table(estimate),
        "",
        "sigma: standard deviation of the residual; worth: how many independent samples the residual amounts to",
        f"largest remaining gradient {certificate.stationarity:.1e} (0 is exact)" + _proof(estimate),
    ]
    if estimate.shares:
        rows.append(_decided(estimate))
    if len(vague):
        worst = vague[np.argsort(-(std / np.maximum(np.abs(values), 1e-12))[vague])]
        names = ", ".join(base.columns[base.independent[i]].name for i in worst[:MAX_NAMES])
        more = f" and {len(vague) - MAX_NAMES} more" if len(vague) > MAX_NAMES else ""
        rows.append(f"vague (standard error above half the value): {names}{more}")
    if estimate.unsized:
        rows.append(
            f"not sized by these data (their torques would be {UNSIZED:g} times the measured one or more, and cancel): "
            + ", ".join(estimate.unsized[:MAX_NAMES])
            + (f" and {len(estimate.unsized) - MAX_NAMES} more" if len(estimate.unsized) > MAX_NAMES else "")
        )
    rows += [f"set-up: {warning}" for warning in estimate.warnings]
    rows.append(_verdict(estimate))
    return "\n".join(rows)


def _verdict(estimate: EstimatedModel) -> str:
    """How much of the torque the model leaves, and only then whether its parameters are physical."""
    relative = np.asarray(estimate.relative)
    poor = relative > POOR
    broken = "; ".join(estimate.violations[:3]) + ("; ..." if len(estimate.violations) > 3 else "")
    if poor.mean() > 0.5:
        links = f"not physical: {broken}" if broken else "its links and friction could exist, but are not this arm's"
        return (
            f"verdict: poor: the model leaves {_percent(relative)} of the torque; {links}\n"
            "  (check signs, gains, columns and robot: physident inspect RECORDING --robot ROBOT)"
        )
    level = f"the model leaves {_percent(relative[~poor])} of the torque"
    doubt = "the set-up is doubtful (see above); " if estimate.warnings else ""
    if poor.any():
        joints = ", ".join(str(j + 1) for j in np.flatnonzero(poor))
        level = f"poor on joint{'s' if poor.sum() > 1 else ''} {joints} ({_percent(relative[poor])} left); elsewhere {level}"
    if broken:
        advice = "(torques determine only sums of parameters; --method physical finds physically consistent values)"
        return f"verdict: {doubt}{level}; not physical: {broken}\n  {advice}"
    return f"verdict: {doubt}{level}; physical: every link is a rigid body, friction dissipates"


def _percent(values: np.ndarray) -> str:
    """The range of values in words: "3 to 13 %"."""
    low, high = (f"{value:.0f}" if value >= 1 else f"{value:.2g}" for value in (values.min(), values.max()))
    return f"{low} %" if low == high else f"{low} to {high} %"


def _prior(estimate: EstimatedModel) -> str:
    assert isinstance(estimate.estimator, Physical)
    prior = estimate.estimator.prior
    if prior.name == "none":
        return ", no prior"
    chosen = " chosen on left-out recordings" if prior.weight == "auto" else ""
    return f", {prior.name} prior of weight {estimate.prior_weight:g}{chosen}"


def _proof(estimate: EstimatedModel) -> str:
    certificate = estimate.certificate
    if not estimate.shares:
        return ""
    smallest = min(certificate.eigenvalues, default=0.0)
    return f", cones violated by {certificate.primal:.1e}, gap {certificate.gap:.1e}; smallest share of a link's pseudo-inertia {smallest:.1e}"


def _decided(estimate: EstimatedModel) -> str:
    shares = np.array(estimate.shares)
    data, prior = np.count_nonzero(shares >= BY_DATA), np.count_nonzero(shares <= BY_PRIOR)
    text = f"of {len(shares)} parameter directions the data determine {data}, the prior {prior}, both {len(shares) - data - prior}"
    dependent = [
        estimate.base.columns[i].name
        for i, s in zip(estimate.base.independent, estimate.base_shares, strict=True)
        if s < BY_DATA
    ]
    if dependent:
        more = f" and {len(dependent) - 8} more" if len(dependent) > 8 else ""
        text += f"\nbase parameters that depend on the prior: {', '.join(dependent[:8])}{more}"
    return text + _active(estimate.active_constraints)


def _active(constraints: tuple[str, ...]) -> str:
    return f"\nactive constraints, without which: {'; '.join(constraints)}" if constraints else ""


def _joint_table(estimate: EstimatedModel) -> list[str]:
    """A row a joint; effects with one parameter a joint are columns, side by side as far as the width goes."""
    model = estimate.model
    counts = Counter((c.effect, c.joint) for c in model.columns)
    apart = {"rigid_body", *(effect.name for effect in model.effects if isinstance(effect, LearnedCurve))}
    effects = [e for e in dict.fromkeys(c.effect for c in model.columns) if e not in apart]
    single = [e for e in effects if all(count == 1 for (name, _), count in counts.items() if name == e)]
    units = {effect: units_in_words(c for c in model.columns if c.effect == effect) for effect in single}
    errors = estimate.standard_errors
    head, unit = ("joint", "error %", "sigma", "worth"), ("", "", f"[{model.robot.torque_unit}]", "")
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
    surest = sorted(others, key=lambda i: -abs(estimate.theta[i]) / max(errors[i], 1e-300))[:MAX_LISTED]
    for i in sorted(surest):
        c = model.columns[i]
        value = "not sized" if c.name in estimate.unsized else f"{_value(estimate.theta[i], errors[i])} {c.unit}"
        rows.append(f"{c.name} = {value}".removesuffix(" 1"))
    if len(others) > MAX_LISTED:
        rows.append(f"and {len(others) - MAX_LISTED} less certain values in the model file")
    rows += _curves(estimate)
    for f in estimate.shape_parameters:
        text = f"{f.effect}, joint {f.joint}: {f.field} {f.value:.4g} ± {f.std:.2g} {f.unit}".removesuffix(" 1")
        cls = CATALOGUE[f.effect]
        (shape,) = [shape for shape in cls.shape_parameters if shape.field == f.field]
        grid = cls.search_grid(model.robot, (f.joint,), shape)
        rows.append(text + ("" if EDGE * grid[0] < f.value < grid[-1] / EDGE else ", at an end of its search grid"))
    return rows


def _curves(estimate: EstimatedModel) -> list[str]:
    """A row for each joint of each learned curve: where it is large, in the place of numbers that say nothing alone."""
    robot = estimate.model.robot
    return [
        f"{effect.name}, {effect.points_in_words(robot, k, *effect.curve(robot, theta, k)[:2])}"
        for effect, theta in estimate.model.effect_parameters()
        if isinstance(effect, LearnedCurve)
        for k in range(len(effect.active(robot)))
    ]


def _cell(estimate: EstimatedModel, errors: np.ndarray, effect: str, joint: int) -> str:
    found = [i for i, c in enumerate(estimate.model.columns) if c.effect == effect and c.joint == joint]
    if found and estimate.model.columns[found[0]].name in estimate.unsized:
        return "not sized"
    return _value(estimate.theta[found[0]], errors[found[0]]) if found else "-"


def _value(value: float, std: float) -> str:
    return f"{value:.4g} (in a sum)" if np.isnan(std) else f"{value:.4g} ± {std:.2g}"
