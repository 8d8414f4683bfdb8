"""A zero that drifts between recordings stays as structure, unless it is allowed for; then it hides no other change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from tests.plant import Arm

pytestmark = pytest.mark.slow

JOINT = 2
DRIFT = 2.0  # N m


def drifted(run: pid.Recording) -> pid.Recording:
    return replace(run, effort=run.effort + DRIFT * (np.arange(6) == JOINT - 1))


def named(diagnosis: pid.Diagnosis) -> set[tuple[str, tuple[int, ...]]]:
    return {(f.effect, f.joints) for f in diagnosis.findings}


def test_a_drifting_zero_is_structure_unless_it_is_allowed_for(
    healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    asked = [healthy_runs[2], drifted(healthy_runs[3])]
    plain = pid.diagnose_motion(healthy_estimate, asked)
    assert plain.verdict in ("unexplained", "partly_explained")
    assert plain.unexplained[JOINT - 1].structured
    allowed = pid.diagnose_motion(healthy_estimate, asked, recording_offsets=True)
    assert allowed.verdict == "nothing_missing"
    assert np.all(allowed.before.rms < 0.5 * DRIFT)


def test_one_recording_cannot_drift(healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]) -> None:
    with pytest.raises(pid.InputError, match="recording_offsets was given with one recording"):
        pid.diagnose_motion(healthy_estimate, healthy_runs[2:3], recording_offsets=True)


def test_behind_a_drift_that_is_allowed_for_a_change_is_found(
    healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    more = 0.5 * Arm().friction.viscous * (np.arange(6) == 4)
    asked = []
    for run in (healthy_runs[2], drifted(healthy_runs[3])):
        assert run.dq is not None
        asked.append(replace(run, effort=run.effort + more * run.dq))
    found = pid.diagnose_motion(healthy_estimate, asked, recording_offsets=True)
    assert named(found) == {("viscous_friction", (5,))}
    assert found.findings[0].parameters[0].change == pytest.approx(more[4], rel=0.15)
