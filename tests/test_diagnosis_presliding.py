"""Friction with a memory: what builds up over a part of a degree is presliding, what needs six degrees is something else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid

pytestmark = pytest.mark.slow

LEVEL = 8.0  # N m


def rubbing(run: pid.Recording, joint: int, travel: float) -> pid.Recording:
    """A recording whose joint also drags a spring that slips once it is stretched by ``travel`` [rad]: a Maxwell slip element."""
    stretch, stretched = 0.0, []
    for step in np.diff(run.q[:, joint - 1], prepend=run.q[0, joint - 1]):
        stretch = float(np.clip(stretch + step, -travel, travel))
        stretched.append(stretch)
    more = np.zeros_like(run.effort)
    more[:, joint - 1] = LEVEL / travel * np.array(stretched)
    return replace(run, effort=run.effort + more)


@pytest.mark.parametrize(("travel", "grade"), [(0.01, "cause"), (0.1, "contribution")])
def test_only_a_short_memory_is_presliding(
    travel: float, grade: str, healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    """Six degrees are no bristle of a gear: the name stands for another law, and the text says why it is no cause."""
    found = pid.diagnose_motion(healthy_estimate, [rubbing(run, 3, travel) for run in healthy_runs[2:]])
    (finding,) = (f for f in found.findings if f.effect == "presliding_hysteresis")
    assert (finding.joints, finding.grade) == ((3,), grade), repr(found)
    (distance,) = (v for v in finding.parameters if v.name == "distance")
    if grade == "cause":
        assert 0.003 < distance.value < 0.01  # exponential, to a level that the spring reaches on a straight line
    else:
        takes, leaves = finding.takes_percent, finding.leaves_percent
        assert takes is not None
        assert leaves is not None
        assert takes > leaves  # the size alone would make it a cause
        assert "its distance lies at the end of the range searched" in " ".join(repr(found).split())
