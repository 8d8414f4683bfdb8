"""The kinds of causes outside the catalogue, by name."""

from __future__ import annotations

import numpy as np

from studies.open_world_second.channel_kinds import CHANNEL_KINDS
from studies.open_world_second.joint_kinds import JOINT_KINDS
from studies.open_world_second.outside import Outside, measured
from studies.open_world_second.structure import STRUCTURES
from studies.open_world_second.survey import survey
from studies.open_world_second.tool_kinds import TOOL_KINDS
from tests.truth import ArmTruth

KINDS = JOINT_KINDS | TOOL_KINDS | CHANNEL_KINDS
NAMES = (*KINDS, *STRUCTURES)


def draw(name: str, arm: ArmTruth, rng: np.random.Generator) -> Outside:
    """A cause of the named kind on an arm; KeyError for an unknown name."""
    usual = survey(arm)
    if name in STRUCTURES:
        return STRUCTURES[name](arm, usual, rng)
    variable, disturbance, ceiling = KINDS[name](arm, usual, rng)
    return measured(name, variable, disturbance, ceiling, usual)
