"""Joints that stand at one exact position while their torque is not that of a joint at rest: an encoder that is frozen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physident.diagnosis.remainder.unexplained import Unexplained
from physident.diagnosis.result.wording import numbered
from physident.recordings.recording import Recording

FROZEN = "the position is the same in every row"


def frozen_words(recordings: Sequence[Recording], unexplained: Sequence[Unexplained]) -> str:
    """Which joints have one exact position in all ``recordings`` and err by far more than on the model's own ones; empty where none does.

    A joint that is held may have one position, too, but then its torque is what the model predicts of a joint at rest, within its friction.
    """
    constant = np.all([np.ptp(recording.q, axis=0) == 0 for recording in recordings], axis=0)
    frozen = [one.joint for one in unexplained if one.grown and constant[one.joint - 1]]
    if not frozen:
        return ""
    return (
        f"{FROZEN} of joint{'s' if len(frozen) > 1 else ''} {numbered(frozen)}, and the torque is not that of a joint at rest: the encoder is frozen, or"
        " the column is not the joint's position; put that right first"
    )
