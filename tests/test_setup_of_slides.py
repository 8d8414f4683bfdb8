"""An arm whose gravity never changes: the force of its slide in kilonewtons is seen by the inertia that it would have."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.setup_checks.check_setup import check_setup
from tests.test_control_shared_torque import BEFORE, QUILL, recorded

TABLE = 0.9  # kg m^2 that turn with the chuck: as strong as what the slide lifts


@pytest.mark.parametrize(("times", "named"), [(1.0, ()), (0.4, ()), (1e-3, (1,))])
def test_a_force_in_another_unit_is_seen_and_a_light_quill_is_not_accused(
    tmp_path: Path, times: float, named: tuple[int, ...]
) -> None:
    path = tmp_path / "quill.urdf"
    path.write_text(QUILL.replace('"0.003"', f'"{0.003 + TABLE}"'))
    one = recorded(1, BEFORE)
    assert one.dq is not None
    effort = one.effort.copy()
    effort[:, 1] += TABLE * np.gradient(one.dq[:, 1], one.time)
    effort[:, 0] *= times
    found = [finding for finding in check_setup(pid.load_robot(path), [replace(one, effort=effort)]) if finding.void]
    assert [finding.joints for finding in found] == ([named] if named else [])
    assert all("unit" in finding.statement for finding in found)


@pytest.mark.parametrize(("turned", "kind"), [("q", "position_sign"), ("effort", "effort_sign")])
def test_a_slide_that_counts_downwards_is_told_from_a_force_of_the_wrong_sign(
    tmp_path: Path, turned: str, kind: str
) -> None:
    path = tmp_path / "quill.urdf"
    path.write_text(QUILL)
    one = recorded(1, BEFORE)
    assert one.dq is not None
    sign = np.array([-1.0, 1.0])
    changed = {"q": sign * one.q, "dq": sign * one.dq} if turned == "q" else {"effort": sign * one.effort}
    (found,) = [finding for finding in check_setup(pid.load_robot(path), [replace(one, **changed)]) if finding.void]
    assert (found.kind, found.joints) == (kind, (1,))
