"""Odd recordings: a joint that never moves, pushes at the same time in two recordings, few joints to tell a force."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.result.text import WIDTH
from physident.diagnosis.result.values import parameter_values, values_in_words
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.diagnosis.statistics.intervals import uncertainty_of
from physident.effects.contact import Contact, tool_jacobian
from tests.test_diagnosis_same_torque import opened_planar

pytestmark = pytest.mark.slow


def pushed(run: pid.Recording, robot: pid.Robot) -> pid.Recording:
    """A recording with 30 N at the tool for two seconds."""
    time = run.time - run.time[0]
    during = ((time >= 5.0) & (time < 7.0))[:, None]
    force = tool_jacobian(robot, run.q).transpose(0, 2, 1) @ np.array([10.0, -20.0, 20.0])
    return replace(run, effort=run.effort + force * during)


def test_pushes_at_the_same_time_of_two_recordings_are_two_findings(
    healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording], tmp_path: Path
) -> None:
    both = [pushed(run, healthy_estimate.model.robot) for run in healthy_runs[2:]]
    found = pid.diagnose_motion(healthy_estimate, both)
    contacts = [f for f in found.findings if f.effect == "contact"]
    assert {f.recording for f in contacts} == {run.sha256 for run in both}
    for f in contacts:
        assert f.intervals[0] == pytest.approx((5.0, 7.0), abs=0.05)
        assert f.gain.reduction_percent > 0
        assert f.gain.interval95[0] > 0
    assert all(f" of {Path(run.source).name}" in repr(found) for run in both)
    assert max(map(len, repr(found).splitlines())) <= WIDTH
    assert found.estimate is not None
    found.estimate.save(tmp_path / "extended.json")
    found.save(tmp_path / "diagnosis.json")
    assert len(pid.load_estimate(tmp_path / "extended.json").model.theta) == len(found.estimate.model.theta)
    pid.write_report(tmp_path / "diagnosis.json", tmp_path / "report.html")
    assert "by the clock of 35.csv" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert json.loads((tmp_path / "diagnosis.json").read_text())["findings"][0]["recording"]


def test_of_a_joint_that_never_moves_no_friction_is_told(
    healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    """Its velocity is noise, whose sign and size are columns like any other."""
    rng = np.random.default_rng(0)
    still = []
    for run in healthy_runs[2:]:
        assert run.dq is not None
        q, dq = run.q.copy(), run.dq.copy()
        q[:, 0], dq[:, 0] = 0.3 + 1e-5 * rng.standard_normal(len(q)), 1e-4 * rng.standard_normal(len(q))
        still.append(replace(run, q=q, dq=dq))
    found = pid.diagnose_motion(healthy_estimate, still)
    accused = {(f.effect, j) for f in found.findings for j in f.joints}
    assert not {name for name, joint in accused if joint == 1 and ("friction" in name or "warm" in name)}
    reasons = {u.reason for u in found.unseen if (u.effect, u.joints) == ("coulomb_friction", (1,))}
    assert reasons == {"of a joint that does not move"}


def test_a_planar_arm_does_not_feel_a_push_across_its_plane(tmp_path: Path) -> None:
    """Its Jacobian has two rows of three: of each piece of a contact the data decide two numbers, and only these are told."""
    opened = opened_planar(tmp_path, 0.0)
    push = AcceptedEffect(CONTACT, Contact(intervals=((5.0, 6.0),), recording=opened.problem.signals[0].recording))
    state = settled_hypothesis(opened.problem, [push])
    assert np.sum(1 - state.left_to_prior(0)) == pytest.approx(2 * 2, abs=0.05)
    told = parameter_values(state, push, uncertainty_of(state))
    assert {value.name for value in told} == {"Fx_5s", "Fz_5s", "Fx_5.5s", "Fz_5.5s"}
    said = values_in_words(state, [push], uncertainty_of(state))
    assert "has another force. The arm does not feel Fy. The strongest push is" in said


LIFT = (
    '<robot name="lift"><link name="base"/><link name="sled"><inertial><mass value="4"/><inertia ixx="0.01" iyy="0.01" izz="0.01" '
    'ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="rail" type="prismatic"><parent link="base"/><child link="sled"/>'
    '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="500" velocity="2"/></joint></robot>'
)


def lifted(seed: int, dry: float, viscous: float = 25.0) -> pid.Recording:
    """Thirty seconds of a sled of 4 kg on a vertical rail, by Newton, with dry friction [N] and viscous friction [N s/m]."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 30.0, 0.005)
    omega, phase = rng.uniform(0.5, 4.0, 4), rng.uniform(0, 2 * np.pi, 4)
    angle = time[:, None] * omega + phase
    q, v, a = (0.06 * x.sum(axis=1) for x in (np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle)))
    force = 4.0 * (a + 9.81) + dry * np.clip(v / 1e-4, -1, 1) + viscous * v + 0.3 * rng.standard_normal(len(time))
    return pid.Recording.from_arrays(time, q[:, None], dq=v[:, None], effort=force[:, None], source=f"{seed} {dry}")


@pytest.mark.parametrize(
    ("dry", "viscous", "effect"), [(14.0, 25.0, "coulomb_friction"), (4.8, 15.0, "friction_level")]
)
def test_the_friction_of_the_only_joint(dry: float, viscous: float, effect: str, tmp_path: Path) -> None:
    """More dry friction is named as what it is by every search, and less friction of every kind as that."""
    (tmp_path / "lift.urdf").write_text(LIFT)
    model = pid.identify(pid.load_robot(tmp_path / "lift.urdf"), [lifted(k, 8.0) for k in range(3)])
    (cause,) = pid.diagnose_motion(model, [lifted(10, dry, viscous), lifted(11, dry, viscous)]).causes
    assert cause.effect == effect
    assert cause.parameters[0].change == pytest.approx(6.0 if dry > 8.0 else -40.0, rel=0.04)
    assert cause.stability is not None
    assert cause.stability > 0.9
