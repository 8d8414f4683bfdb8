"""What a model's own recordings show is told apart from what changed, and what they tell limits how far the model may move."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.grading.completed import complete_model
from physident.diagnosis.problem.question import parameter_freedom
from physident.dynamics.regressor import build_regressor
from physident.estimation.identify import prepare_all
from tests.opened import opened
from tests.searched_once import searched_once

pytestmark = pytest.mark.slow

RIPPLED, HEAVIER = 3, 2  # joints, from 1
ORDER = 8  # nearly three periods of the ripple in the 2.1 rad that the first two recordings cover: fewer than two are any curve


def with_fault(run: pid.Recording, also_heavier: bool) -> pid.Recording:
    """A recording of an arm whose joint 3 always rippled, and whose joint 2 became more viscous."""
    v = run.dq
    assert v is not None
    torque = np.zeros_like(run.q)
    torque[:, RIPPLED - 1] = 2.0 * np.sin(ORDER * run.q[:, RIPPLED - 1] + 0.4)
    if also_heavier:
        torque[:, HEAVIER - 1] = 9.0 * v[:, HEAVIER - 1]
    return replace(run, effort=run.effort + torque)


@dataclass(frozen=True)
class Runs:
    """An arm's model, and its recordings from before and after a change."""

    estimate: pid.Estimate
    before: list[pid.Recording]
    after: list[pid.Recording]


@pytest.fixture(scope="module")
def runs(ur5: pid.Robot, healthy_runs: list[pid.Recording], tmp_path_factory: pytest.TempPathFactory) -> Runs:
    folder = tmp_path_factory.mktemp("completed")
    before = [stored(with_fault(run, False), folder / f"before{k}.csv") for k, run in enumerate(healthy_runs[:2])]
    after = [stored(with_fault(run, True), folder / f"after{k}.csv") for k, run in enumerate(healthy_runs[2:])]
    return Runs(pid.identify(ur5, before), before, after)


@pytest.fixture(scope="module")
def found(runs: Runs) -> pid.Diagnosis:
    return pid.diagnose_motion(runs.estimate, runs.after)


def stored(run: pid.Recording, path: Path) -> pid.Recording:
    """The recording as a file, so that it can be found again."""
    assert run.dq is not None
    names = [f"{name}_{j + 1}" for name in ("q", "dq", "tau") for j in range(run.n)]
    table = np.column_stack([run.time, run.q, run.dq, run.effort])
    np.savetxt(path, table, delimiter=",", header=",".join(["time", *names]), comments="", fmt="%.12g")
    return pid.load_recording(path)


def test_an_old_fault_is_missing_since_before_and_only_the_change_is_a_cause(found: pid.Diagnosis) -> None:
    assert [(f.effect, f.joints) for f in found.causes] == [("viscous_friction", (HEAVIER,))]
    assert ("torque_ripple", (RIPPLED,)) in [(f.effect, f.joints) for f in found.missing_since_before]
    assert found.controlled
    rows = str(found).splitlines()
    (head,) = [
        k for k, row in enumerate(rows) if row.startswith("missing since before, for the model's own recordings")
    ]
    listed = " ".join(row for row in rows[head:] if row.startswith(" "))
    assert f"torque_ripple (joint {RIPPLED})" in listed
    assert "missing since before" not in listed  # said once for all


def test_the_model_s_own_recordings_given_as_those_from_before_show_the_same(runs: Runs, found: pid.Diagnosis) -> None:
    """Under other names, as after a move, they are known by what they hold; and what the model always lacked is in all of them."""
    elsewhere = replace(
        runs.estimate, sources=tuple(replace(one, path=f"gone/{one.path}") for one in runs.estimate.sources)
    )
    given = pid.diagnose_motion(elsewhere, runs.after, before=runs.before)
    assert [f.parameters for f in given.findings] == [f.parameters for f in found.findings]
    assert [f.parameters for f in given.missing_since_before] == [f.parameters for f in found.missing_since_before]


def test_what_does_not_hold_on_the_new_recordings_is_not_added(
    ur5: pid.Robot, healthy_runs: list[pid.Recording], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Twice the same ripple before; then it is there, or gone. What went shall not be put into the model first."""
    before = [with_fault(run, False) for run in healthy_runs[:2]]
    estimate = pid.identify(ur5, before)
    searched_once(monkeypatch)  # what the recordings from before show is the same
    for asked, expected in (([with_fault(run, False) for run in healthy_runs[2:]], True), (healthy_runs[2:], False)):
        completed = complete_model(estimate, before, asked, 0, lambda _: None)
        rippled = [f for f in completed.findings if RIPPLED in f.joints]
        assert bool(rippled) is expected


def test_the_change_has_its_value(found: pid.Diagnosis) -> None:
    (value,) = found.causes[0].parameters
    assert value.change == pytest.approx(9.0, rel=0.1)


def test_the_extended_model_holds_the_old_fault_too(found: pid.Diagnosis) -> None:
    """The error is that of the model as given, and the extended model mends both joints."""
    joints = [RIPPLED - 1, HEAVIER - 1]
    assert (found.after.rms[joints] < 0.6 * found.before.rms[joints]).all()


def test_prior_knowledge_is_that_of_the_fitted_rows(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> None:
    """How far a parameter may move does not depend on the motion that is asked about, be it ever so poor."""
    estimate = pid.identify(ur5, healthy_runs[:2])
    spreads = []
    for run in (healthy_runs[2], _first_seconds(healthy_runs[3], 4.0)):
        signals = prepare_all(ur5, [run], estimate.filter)
        regressor = build_regressor(ur5, estimate.model.effects, signals, estimate.filter)
        freedom = parameter_freedom(estimate, "different", regressor)
        spreads.append(np.sqrt((freedom.map**2).sum(axis=1)))
    assert spreads[1] == pytest.approx(spreads[0], rel=1e-6)


def test_information_is_that_of_rows_as_independent_as_they_are(healthy_estimate: pid.Estimate) -> None:
    assert healthy_estimate.information is not None
    information = healthy_estimate.information
    assert np.linalg.eigvalsh(information).min() > -1e-9 * np.linalg.eigvalsh(information).max()
    # the jackknife, which knows nothing of it, gives standard errors of the same size
    ratio = np.sqrt(np.diag(np.linalg.pinv(information)) / np.diag(healthy_estimate.covariance))
    assert 0.3 < np.median(ratio) < 3


def test_it_survives_the_model_file(healthy_estimate: pid.Estimate, tmp_path: Path) -> None:
    healthy_estimate.save(tmp_path / "model.json")
    again = pid.load_estimate(tmp_path / "model.json").information
    assert again is not None
    assert healthy_estimate.information is not None
    assert np.array_equal(again, healthy_estimate.information)


def test_each_joint_of_an_effect_changes_by_itself(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> None:
    from physident.diagnosis.grading.control import changes_since
    from tests.test_diagnosis_changes import accepted

    before = [with_fault(run, False) for run in healthy_runs[:2]]
    after = [with_fault(run, True) for run in healthy_runs[2:]]
    state = accepted(opened(ur5, [*before, *after]), "viscous_friction", joints=(RIPPLED,))
    both = accepted(opened(ur5, [*before, *after]), "viscous_friction", joints=(HEAVIER,))
    control = prepare_all(ur5, before, state.problem.filter)
    assert changes_since(state, control)["viscous_friction", (RIPPLED,)].size == 0
    assert min(one.size for one in changes_since(both, control).values()) > 0.5


def _first_seconds(run: pid.Recording, seconds: float) -> pid.Recording:
    rows = run.time < run.time[0] + seconds
    assert run.dq is not None
    return replace(run, time=run.time[rows], q=run.q[rows], dq=run.dq[rows], effort=run.effort[rows])


def test_own_recordings_that_cannot_be_searched_are_said_to_be(
    healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object, **__: object) -> None:
        raise pid.InputError("too short")

    monkeypatch.setattr("physident.diagnosis.grading.completed.search_and_learn", refused)
    with pytest.warns(pid.PhysidentWarning, match="may be named as a change.*too short"):
        kept = complete_model(healthy_estimate, healthy_runs[:2], healthy_runs[2:], 0, lambda _: None)
    assert kept.estimate is healthy_estimate
    assert kept.findings == ()
