"""An estimate as a notebook shows it."""

from __future__ import annotations

import numpy as np

from physident.effects.classification import units_in_words
from physident.estimation.estimated_model import EstimatedModel
from physident.notebook import results_html


def estimate_html(estimate: EstimatedModel, text: str) -> str:
    """A row for each joint, with its error and every parameter that belongs to a joint; title and verdict are those of ``text``."""
    robot, lines = estimate.model.robot, text.splitlines()
    columns = {
        (c.effect, c.joint): k for k, c in enumerate(estimate.model.columns) if c.name == f"{c.effect}_{c.joint}"
    }
    effects = list(dict.fromkeys(effect for effect, _ in columns))
    units = {name: units_in_words(c for c in estimate.model.columns if c.effect == name) for name in effects}
    head = [
        "joint",
        "error [%]",
        f"sigma [{robot.torque_unit}]",
        "independent samples",
        *(f"{name} [{units[name]}]" for name in effects),
    ]
    rows = [
        [
            f"{j} {robot.joint_names[j - 1]}",
            f"{estimate.relative[j - 1]:.2f}",
            f"{estimate.sigma[j - 1]:.3g}",
            f"{estimate.effective_samples[j - 1]:.0f}",
            *(_value(estimate, columns.get((name, j))) for name in effects),
        ]
        for j in range(1, robot.n + 1)
    ]
    verdict = " ".join(lines[next((k for k, line in enumerate(lines) if line.startswith("verdict")), len(lines)) :])
    return results_html(lines[0], head, rows, verdict)


def _value(estimate: EstimatedModel, index: int | None) -> str:
    """A value with its standard error; one that is only known in a sum has none."""
    if index is None:
        return ""
    error = estimate.standard_errors[index]
    return f"{estimate.theta[index]:.4g}" + (f" ± {error:.2g}" if np.isfinite(error) else " (in a sum)")
