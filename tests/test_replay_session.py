"""The session of a replay: measured and simulated arms, and a table that no name can break."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.estimation.estimate import as_estimate
from physident.replay.replay import Replayed, replay
from physident.replay.session import _summary, write_replay
from tests.exported_arms import named_after_code, physical_model


@pytest.fixture(scope="module")
def replayed() -> Replayed:
    """An arm whose names are code, and one that carries twice as much, on a recording of the first."""
    model = physical_model(named_after_code(), seed=8)
    heavy = pid.Model(model.robot, model.effects, np.where(np.arange(len(model.theta)) < 20, 2.0, 1.0) * model.theta)
    recording = pid.simulate(model, pid.random_trajectory(model.robot, seed=1, duration=10.0))
    before, after = (as_estimate(one, pid.Filter()) for one in (heavy, model))
    return replay(before, after, [recording], "mujoco", 0.2)


def test_a_table_has_a_row_a_joint_whatever_its_name(replayed: Replayed) -> None:
    lines = _summary(replayed.replay).splitlines()
    rows = [line for line in lines if line.startswith("|")]
    assert len(rows) == 2 + len(replayed.replay.joints)
    assert all(row.replace(r"\|", "").count("|") == 5 for row in rows)
    assert not [line for line in lines if "<b>" in line or "`y`" in line]
    before, after = replayed.replay.before, replayed.replay.after
    assert after is not None
    assert f"{1e3 * before.position[0]:.3g} → {1e3 * after.position[0]:.3g}" in rows[2]
    assert replayed.replay.verdict in lines[0]


def test_measured_and_simulated_arms_are_in_the_file(replayed: Replayed, tmp_path: Path) -> None:
    from rerun.chunk import RrdReader

    path = tmp_path / "r.rrd"
    write_replay(replayed, named_after_code(), path)
    paths = {chunk.entity_path for chunk in RrdReader(path).stream()}
    for arm in ("measured", "as_it_was", "extended"):
        assert {f"/{arm}/link_{j}" for j in (1, 2)} | {f"/{arm}/tool"} <= paths
    for arm in ("as_it_was", "extended"):
        assert {f"/{arm}/gap", f"/error/tool/{arm}", f"/error/joint_2/{arm}"} <= paths
    with pytest.raises(pid.InputError, match="rrd"):
        write_replay(replayed, named_after_code(), tmp_path / "r.txt")
    assert [file.name for file in tmp_path.iterdir()] == ["r.rrd"]
