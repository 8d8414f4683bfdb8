"""The baseline of an arm with the laws of friction that its recordings show: what a model lacks returns in every change measured beside it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.effects.catalogue import DEFAULT_EFFECTS
from physident.errors import PhysidentError
from physident.estimation.estimate import Estimate
from physident.estimation.identify import identify
from physident.fleet.candidates import LAWS
from physident.recordings.recording import Recording
from physident.robots.robot import Robot
from physident.validation.scores import scored

Array = NDArray[np.float64]


def identify_with_friction_laws(robot: Robot, recordings: Sequence[Recording], cutoff: float | None = None) -> Estimate:
    """The default model with each law of friction that makes the error on left-out recordings smaller, identified from all.

    Half of the recordings are predicted by a model of the other half, and the other way round; a law stays where both errors
    fall. A single recording gives the default model. Raises InputError as ``identify`` does.
    """
    chosen = tuple(DEFAULT_EFFECTS)
    if len(recordings) > 1:
        halves = recordings[::2], recordings[1::2]
        errors = _left_out(robot, halves, chosen, cutoff)
        for law in LAWS:
            found = _left_out(robot, halves, (*chosen, law), cutoff)
            if errors is not None and found is not None and ((found / errors) ** 2).mean(axis=1).max() < 1:
                chosen, errors = (*chosen, law), found
    return identify(robot, recordings, chosen, filter=cutoff)


def _left_out(
    robot: Robot, halves: tuple[Sequence[Recording], ...], effects: Sequence[str], cutoff: float | None
) -> Array | None:
    """RMS error (2, n) [N m|N] of each half by the model of the other one; None where a half is not enough for the model."""
    try:
        return np.array(
            [scored(identify(robot, halves[k], effects, filter=cutoff), halves[1 - k]).rms for k in range(len(halves))]
        )
    except PhysidentError:
        return None
