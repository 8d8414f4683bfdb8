"""Where a simulated motion leaves the range that a learned curve was learned from."""

from __future__ import annotations

from physident.dynamics.model import Model
from physident.effects.learned.curve import LearnedCurve
from physident.errors import warn
from physident.recordings.signals import Signals

BEYOND = 0.05  # of the range: a controller's error at its ends is no new place


def warn_beyond_curves(model: Model, truth: Signals) -> None:
    """Warn for every learned curve whose joint leaves its range: there it is continued, and nobody has measured it."""
    curves = [effect for effect in model.effects if isinstance(effect, LearnedCurve)]
    states = model.refer(truth) if curves else truth
    for curve in curves:
        for k, j in enumerate(curve.active(model.robot)):
            one = curve.of_joint(model.robot, k)
            values = one.quantity(states)
            low, high = one.ends(model.robot)
            if values is None or one.circles(model.robot).all():  # a whole turn has no ends
                continue
            least, most = float(values[:, j].min()), float(values[:, j].max())
            margin = BEYOND * (high - low)
            if least < low - margin or most > high + margin:
                unit = one.unit_of_quantity(model.robot, j)
                warn(
                    f"joint {j + 1} leaves what {curve.name} was learned from: {least:.3g} to {most:.3g} {unit} instead of"
                    f" {low:.3g} to {high:.3g} {unit}; beyond, the curve is continued and not known"
                )
