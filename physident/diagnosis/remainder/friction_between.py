"""What of a residual is friction that differs from one recording to the next: no function of a joint's state describes it.

A joint's friction changes by some per cent from day to day, with its temperature, and with what it did before. A model of several
recordings has one friction for all, and leaves each of them what that differs by.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.search.hypothesis import Hypothesis
from physident.dynamics.friction_parameters import friction_places
from physident.effects.classification import Family
from physident.large_arrays import steps

Array = NDArray[np.float64]
FEWEST = 3  # recordings: of two, each differs from the other by whatever either lacks
LITTLE = 0.05  # of the power: a smaller share is not worth a word


@dataclass(frozen=True, kw_only=True)
class FrictionBetween:
    """At most this ``share`` of a residual's power is friction that is more or less in one recording than in the others, by up to
    ``percent`` [%] of itself."""

    share: float
    percent: float

    @property
    def in_words(self) -> str:
        """As a part of a sentence about the residual."""
        return (
            f"at most {100 * self.share:.0f} % of it is friction that differs from one recording to the next, by up to"
            f" {self.percent:.2g} % of itself"
        )


def friction_between(hypothesis: Hypothesis) -> tuple[FrictionBetween | None, ...]:
    """That of each joint's residual; None where it is little, where fewer than FEWEST recordings tell, and where the question is what changed:
    there a change is held against what healthy recordings differ by.

    In each recording the friction of the extended model may have a size of its own. What as many sizes would explain of noise that
    remembers as long as the residual does is taken off.
    """
    problem = hypothesis.problem
    recording, n = problem.regressor.recording, len(hypothesis.fit.sigma)
    numbers = np.unique(recording)
    if problem.question == "different" or len(numbers) < FEWEST:
        return (None,) * n
    found = []
    for friction, left, memory in zip(
        np.sum(friction_torque(hypothesis), axis=0).T, hypothesis.fit.residual.T, hypothesis.fit.memory, strict=True
    ):
        parts = [(friction[some], left[some]) for some in (recording == one for one in numbers)]
        squares = np.array([f @ f for f, _ in parts])
        pushes = np.array([f @ r for f, r in parts])
        shown = squares > 0
        sizes = pushes[shown] / squares[shown]
        share = float(sizes @ pushes[shown]) / max(float(left @ left), 1e-300) - len(sizes) * float(memory) / len(left)
        percent = 100 * float(np.max(np.abs(sizes), initial=0.0))
        found.append(FrictionBetween(share=share, percent=percent) if share > LITTLE else None)
    return tuple(found)


def friction_torque(hypothesis: Hypothesis) -> tuple[Array, Array]:
    """The torques (M, n) [N m|N] of the extended model's dry friction and of all its other friction in the weighted rows."""
    model = hypothesis.problem.model
    dry, other = (
        _torque_of(hypothesis, (model.theta + _moved(hypothesis)) * places) for places in friction_places(model)
    )
    for i, one in enumerate(hypothesis.accepted):
        if one.effect.family is Family.FRICTION:
            part = dry if one.effect.dry else other
            part += hypothesis.torque_of(i)
    return dry, other


def moved_friction(hypothesis: Hypothesis) -> Array:
    """The torque (M, n) [N m|N] by which the model's own friction has moved beside the accepted effects."""
    return _torque_of(hypothesis, _moved(hypothesis) * np.any(friction_places(hypothesis.problem.model), axis=0))


def _moved(hypothesis: Hypothesis) -> Array:
    """By how much the model's parameters (p,) have moved beside the accepted effects."""
    freedom = hypothesis.problem.freedom
    return freedom.map @ hypothesis.fit.x[: len(freedom.prior)]


def _torque_of(hypothesis: Hypothesis, theta: Array) -> Array:
    """The torque (M, n) [N m|N] that some values of the model's parameters (p,) make in the weighted rows."""
    total = np.zeros(hypothesis.fit.residual.shape)
    for j, joint in enumerate(hypothesis.problem.regressor.joints):
        values = np.zeros(len(joint.columns))
        own = joint.columns < len(theta)
        values[own] = theta[joint.columns[own]]
        if values.any():
            for some in steps(len(total)):
                total[some, j] = joint.some(some) @ values
    return total
