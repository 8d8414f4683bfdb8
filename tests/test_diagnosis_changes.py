"""What is called a change: its sign is the same in every recording, the control does not show it, and what else differs is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.grading.confounders import PARTLY_KNOWN, UNKNOWN, friction_confounder, with_confounder
from physident.diagnosis.grading.control import changes_of
from physident.diagnosis.grading.signs import amplitudes, changes_sign
from physident.diagnosis.result.findings import Finding, Reduction
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.diagnosis.search.hypothesis import AcceptedEffect, Hypothesis
from physident.estimation.identify import prepare_all
from tests.opened import opened

JOINT = 3


def with_torque(run: pid.Recording, factor: float, wave: str) -> pid.Recording:
    """A recording with a torque on joint 3 that follows its velocity, or its sign."""
    v = run.dq
    assert v is not None
    shape = v if wave == "viscous" else np.tanh(v / 0.01)
    return replace(run, effort=run.effort + factor * shape * (np.arange(6) == JOINT - 1))


def accepted(state: Hypothesis, *names: str, joints: tuple[int, ...] = (JOINT,)) -> Hypothesis:
    """The hypothesis with some effects accepted on a joint, each with the smallest shape of its grid."""
    found = {c.key: c for c in state.data.candidates}
    chosen = []
    for name in names:
        effect = found[name, joints].options[0].effect
        assert effect is not None
        chosen.append(AcceptedEffect(found[name, joints], effect))
    return settled_hypothesis(state.problem, chosen)


@pytest.mark.parametrize(("second", "expected"), [(3.0, False), (0.0, False), (-2.0, True)])
def test_a_coefficient_of_the_other_sign_in_a_recording_is_no_cause(
    ur5: pid.Robot, healthy_runs: list[pid.Recording], second: float, expected: bool
) -> None:
    runs = [
        *healthy_runs[:2],
        with_torque(healthy_runs[2], 4.0, "viscous"),
        with_torque(healthy_runs[3], second, "viscous"),
    ]
    state = accepted(opened(ur5, runs), "viscous_friction")
    (one,) = state.accepted
    factor, error = amplitudes(state, one)
    assert factor[0] > 0
    assert factor[1] * 4.0 == pytest.approx(factor[0] * second, abs=0.3 * factor[0] * 4.0 + 8 * error[1] * 4.0)
    assert changes_sign(state, one) is expected


def changed(
    ur5: pid.Robot,
    before: list[pid.Recording],
    after: list[pid.Recording],
    *names: str,
    joints: tuple[int, ...] = (JOINT,),
) -> tuple[bool, ...]:
    """Which of some effects differ between recordings before and after, each a group of its own."""
    state = accepted(opened(ur5, [*before, *after]), *names, joints=joints)
    control = prepare_all(ur5, before, state.problem.filter)
    return tuple(one.size != 0 for one in changes_of(state, control, range(len(names))))


def test_a_change_is_new_and_what_both_hold_is_not(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> None:
    more = [with_torque(run, 3.0, "viscous") for run in healthy_runs]
    assert changed(ur5, healthy_runs[:2], more[2:], "viscous_friction") == (True,)
    assert changed(ur5, more[:2], more[2:], "viscous_friction") == (False,)


def test_a_change_is_larger_than_what_healthy_recordings_differ_by(
    ur5: pid.Robot, healthy_runs: list[pid.Recording]
) -> None:
    """The model's own recordings have more and less of it than the new one: this arm is never twice the same."""
    new = with_torque(healthy_runs[3], 2.6, "viscous")
    for factors, expected in (((0.0, 3.0, 0.5), False), ((1.2, 1.2, 1.2), True)):
        before = [with_torque(run, f, "viscous") for run, f in zip(healthy_runs[:3], factors, strict=True)]
        state = accepted(opened(ur5, [*before[:2], new]), "viscous_friction")
        control = prepare_all(ur5, before, state.problem.filter)
        assert tuple(one.size != 0 for one in changes_of(state, control, [0])) == (expected,), factors


def test_of_two_effects_alike_the_one_that_the_model_has_is_what_changed(
    ur5: pid.Robot, healthy_runs: list[pid.Recording]
) -> None:
    """Both could hold the difference, and neither may hide it."""
    more = [with_torque(run, 2.0, "dry") for run in healthy_runs[2:]]
    assert changed(ur5, healthy_runs[:2], more, "presliding_hysteresis", "coulomb_friction") == (False, True)


def test_ten_numbers_change_though_there_are_few_blocks(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> None:
    """What is tested is by how much of itself a payload differs."""
    robot = ur5
    signals = prepare_all(robot, healthy_runs[2:], pid.identify(robot, healthy_runs[:2]).filter)
    payload = pid.CATALOGUE["payload"]()
    values = np.array([1.5, 0.0, 0.0, 0.1, 0.01, 0.0, 0.01, 0.0, 0.0, 0.01])
    loaded = []
    for run, one in zip(healthy_runs[2:], signals, strict=True):
        torque = payload.regressor(robot, one) @ values
        part = np.column_stack([np.interp(run.time, one.time + one.origin, column) for column in torque.T])
        loaded.append(replace(run, effort=run.effort + part))
    short = [replace(run, **_first(run, 0.4)) for run in loaded]
    assert changed(robot, healthy_runs[:2], short, "payload", joints=()) == (True,)


def _first(run: pid.Recording, share: float) -> dict[str, np.ndarray]:
    """The first part of a recording's rows."""
    count = int(share * len(run.time))
    assert run.dq is not None
    return {"time": run.time[:count], "q": run.q[:count], "dq": run.dq[:count], "effort": run.effort[:count]}


def test_unequal_temperature_is_named_beside_friction_alone(healthy_runs: list[pid.Recording]) -> None:
    def at(run: pid.Recording, degrees: float) -> pid.Recording:
        return replace(run, temperature=np.full_like(run.q, degrees))

    before, after = [at(run, 25.0) for run in healthy_runs[:2]], [at(run, 33.0) for run in healthy_runs[2:]]
    text = friction_confounder(before, after)
    assert "25 degC" in text
    assert "33 degC" in text
    assert friction_confounder(before, [at(run, 25.5) for run in healthy_runs[2:]]) == ""
    assert friction_confounder([], after) == ""
    assert friction_confounder(healthy_runs[:2], after) == friction_confounder(before, healthy_runs[2:]) == PARTLY_KNOWN
    named = with_confounder([finding("viscous_friction"), finding("payload")], before, after)
    assert [f.confounder for f in named] == [text, ""]


def test_unequal_time_since_the_start_is_named(healthy_runs: list[pid.Recording]) -> None:
    later = [replace(run, time=run.time + 1200.0) for run in healthy_runs[2:]]
    assert "20 min later" in friction_confounder(healthy_runs[:2], later)
    assert "20 min earlier" in friction_confounder(later, healthy_runs[:2])
    assert friction_confounder(healthy_runs[:2], healthy_runs[2:]) == UNKNOWN


def finding(effect: str) -> Finding:
    gain = Reduction(rms_before=1.0, rms_after=0.5, reduction_percent=50.0, interval95=(40.0, 60.0))
    return Finding(effect=effect, joints=(), parameters=(), gain=gain, rivals=(), intervals=(), advice="", evidence=1.0)


@pytest.mark.slow
def test_a_temperature_that_nobody_measured_before_is_taken_for_the_first_one(
    ur5: pid.Robot, healthy_runs: list[pid.Recording], healthy_estimate: pid.Estimate
) -> None:
    """Friction that falls with a measured temperature is found, though the model's own recordings have none."""
    warm = []
    for run in healthy_runs[2:]:
        assert run.dq is not None
        hot = 20.03 + 15.0 * (1 - np.exp(-(run.time - run.time[0]) / 6.0))
        slower = np.tanh(run.dq / 0.02) * (-0.12 * (hot - 20.03))[:, None] * (np.arange(6) == JOINT - 1)
        warm.append(replace(run, effort=run.effort + slower, temperature=np.tile(hot[:, None], (1, 6))))
    with pytest.warns(pid.PhysidentWarning, match="taken to be as warm as where these begin, 20.0 degC"):
        found = pid.diagnose_motion(healthy_estimate, warm)
    first = found.causes[0]
    assert (first.effect, first.joints) == ("warm_up", (JOINT,))
    assert first.parameters[0].unit == "N m/degC"
    assert first.parameters[0].change == pytest.approx(-0.12, rel=0.15)
    assert any("record temperatures both times" in text for text in found.warnings)
