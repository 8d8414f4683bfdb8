"""Friction of a cold joint fades over minutes; what fades within a few seconds is something else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid

pytestmark = pytest.mark.slow

LEVEL = 25.0  # N m


def fading(run: pid.Recording, joint: int, seconds: float) -> pid.Recording:
    """A recording whose joint drags against more dry friction, which halves every so many seconds."""
    assert run.dq is not None
    v, more = run.dq[:, joint - 1], np.zeros_like(run.effort)
    more[:, joint - 1] = LEVEL * 0.5 ** ((run.time - run.time[0]) / seconds) * v / (np.abs(v) + 0.005)
    return replace(run, effort=run.effort + more)


@pytest.mark.parametrize(("seconds", "grade"), [(7.0, "cause"), (1.5, "contribution")])
def test_what_fades_within_seconds_is_no_warmth(
    seconds: float, grade: str, healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    """The name stands for another law then, and the text says why it is no cause."""
    found = pid.diagnose_motion(healthy_estimate, [fading(run, 3, seconds) for run in healthy_runs[2:]])
    (finding,) = (f for f in found.findings if f.effect == "warm_up")
    assert (finding.joints, finding.grade) == ((3,), grade), repr(found)
    if grade == "contribution":
        takes, leaves = finding.takes_percent, finding.leaves_percent
        assert takes is not None
        assert leaves is not None
        assert takes > leaves  # the size alone would make it a cause
        assert "its best shape lies beyond what is physical" in " ".join(repr(found).split())
