"""Which motions people record: mostly designed ones and programs, now and then a poor one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from studies.open_world_second import steps, waves
from tests.truth import ArmTruth, Motion

Plan = Callable[[ArmTruth, int, float], Motion]
KINDS: dict[str, tuple[float, Plan]] = {
    "fourier": (0.3, waves.fourier),
    "errands": (0.2, steps.errands),
    "program": (0.18, steps.program),
    "lissajous": (0.14, waves.lissajous),
    "teaching": (0.1, steps.teaching),
    "chirp": (0.08, waves.chirp),
}


def draw(arm: ArmTruth, seed: int, duration: float) -> Motion:
    """A motion [s] inside the arm's limits, of a kind that follows from the seed."""
    shares = np.array([share for share, _ in KINDS.values()])
    kind = np.random.default_rng([seed, 410]).choice(list(KINDS), p=shares / shares.sum())
    return KINDS[str(kind)][1](arm, seed, duration)
