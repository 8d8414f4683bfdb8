"""Effects hidden by an independent plant are named, located and measured; what is not there is not named."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from tests.exact_friction import exact_arm
from tests.made_once import STEP
from tests.plant import Arm, Sensors, hide, multisine, record


def recorded(folder: Path, name: str, arm: Arm, seed: int) -> pid.Recording:
    path = folder / f"{name}_{seed}.csv"
    record(arm, multisine(seed), Sensors(), seed, step=STEP).write_csv(path)
    return pid.load_recording(path)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("runs")


@pytest.fixture(scope="module")
def clean(folder: Path) -> list[pid.Recording]:
    return [recorded(folder, "clean", exact_arm(), seed) for seed in (1, 3, 5)]


@pytest.fixture(scope="module")
def changed(folder: Path) -> list[pid.Recording]:
    arm = hide(hide(exact_arm(), "load_dependent_friction", 2, 0.08), "coulomb_friction", 4, 0.5)
    return [recorded(folder, "changed", arm, seed) for seed in (7, 9)]


@pytest.fixture(scope="module")
def estimate(ur5: pid.Robot, clean: list[pid.Recording]) -> pid.Estimate:
    return pid.identify(ur5, clean[:2])


@pytest.fixture(scope="module")
def different(estimate: pid.Estimate, changed: list[pid.Recording]) -> pid.Diagnosis:
    return pid.diagnose_motion(estimate, changed)


def test_two_hidden_changes_are_named_on_their_joints_with_their_values(different: pid.Diagnosis) -> None:
    assert different.question == "different"
    found = {f.effect: f for f in different.findings}
    assert set(found) == {"load_dependent_friction", "coulomb_friction"}
    (mu,) = found["load_dependent_friction"].parameters
    (dry,) = found["coulomb_friction"].parameters
    assert (mu.joint, dry.joint) == (2, 4)
    assert mu.value == pytest.approx(0.08, rel=0.1)
    assert dry.change == pytest.approx(0.5, rel=0.1)
    assert mu.interval95[0] < mu.value < mu.interval95[1]


def test_findings_come_in_order_of_evidence_and_no_placebo_passes(different: pid.Diagnosis) -> None:
    evidence = [f.evidence for f in different.findings]
    assert evidence == sorted(evidence, reverse=True)
    assert different.placebos
    assert not any(p.passed for p in different.placebos)


def test_the_extended_model_predicts_an_unseen_run_of_the_changed_arm(
    different: pid.Diagnosis, estimate: pid.Estimate, folder: Path
) -> None:
    arm = hide(hide(exact_arm(), "load_dependent_friction", 2, 0.08), "coulomb_friction", 4, 0.5)
    unseen = recorded(folder, "unseen", arm, 11)
    assert different.estimate is not None
    gain = pid.compare(estimate, different.estimate, [unseen])
    assert gain.reduction[1] > 50
    assert gain.reduction[3] > 50
    saved = folder / "extended.json"
    different.estimate.save(saved)
    again = pid.compare(estimate, pid.load_estimate(saved), [unseen])
    np.testing.assert_allclose(again.after.rms, gain.after.rms, rtol=1e-9)


def test_an_unchanged_arm_is_accused_of_nothing(estimate: pid.Estimate, clean: list[pid.Recording]) -> None:
    diagnosis = pid.diagnose_motion(estimate, clean[2:])
    assert diagnosis.findings == ()
    assert diagnosis.estimate is None


@pytest.mark.slow
def test_a_holdout_that_errs_refutes_that_all_is_noise(
    estimate: pid.Estimate, clean: list[pid.Recording], changed: list[pid.Recording]
) -> None:
    """What was fitted shows nothing; the held-out run is that of an arm with load-dependent friction and more dry friction."""
    diagnosis = pid.diagnose_motion(estimate, clean[:2], holdout=changed[:1])
    assert diagnosis.findings == ()
    assert diagnosis.verdict == "unexplained"
    assert {2, 4} <= set(diagnosis.wrong_unseen) <= {1, 2, 3, 4}
    assert pid.diagnose_motion(estimate, clean[:2], holdout=clean[2:3]).wrong_unseen == ()


@pytest.mark.slow
def test_an_unchanged_arm_of_another_law_is_accused_of_nothing(ur5: pid.Robot, folder: Path) -> None:
    runs = [recorded(folder, "other_law", Arm(), seed) for seed in (1, 3, 5)]
    assert pid.diagnose_motion(pid.identify(ur5, runs[:2]), runs[2:]).findings == ()


@pytest.mark.slow
def test_what_a_model_was_fitted_without_is_missing_from_it(ur5: pid.Robot, changed: list[pid.Recording]) -> None:
    fitted = pid.identify(ur5, changed)
    diagnosis = pid.diagnose_motion(fitted, changed)
    assert diagnosis.question == "missing"
    first = diagnosis.findings[0]
    assert (first.effect, first.joints) == ("load_dependent_friction", (2,))
    assert diagnosis.estimate is not None
    assert diagnosis.estimate.model.parameters("load_dependent_friction")[0] == pytest.approx(0.08, rel=0.1)
    unseen = {(u.effect, u.joints) for u in diagnosis.unseen}
    assert ("coulomb_friction", (4,)) in unseen  # a refitted baseline takes it up
    assert diagnosis.after.rms[1] < 0.6 * diagnosis.before.rms[1]


@pytest.mark.slow
def test_a_push_on_the_tool_is_found_with_its_time_and_force(estimate: pid.Estimate, folder: Path) -> None:
    arm = hide(exact_arm(), "contact", (), 20.0, start=6.0, end=7.5, direction=(0.0, 1.0, 0.0))
    diagnosis = pid.diagnose_motion(estimate, [recorded(folder, "contact", arm, 13)])
    (finding,) = diagnosis.findings
    assert (finding.effect, finding.joints) == ("contact", ())
    assert finding.grade == "cause"
    assert finding.takes_percent is not None
    assert finding.takes_percent > 90  # while it lasts; of the whole recording it is a tenth
    ((start, end),) = finding.intervals
    assert start == pytest.approx(6.0, abs=0.26)
    assert end == pytest.approx(7.5, abs=0.51)
    middle = [v.value for v in finding.parameters[:3]] if len(finding.parameters) == 3 else [
        v.value for v in finding.parameters[3:6]
    ]  # fmt: skip
    np.testing.assert_allclose(middle, [0, 20, 0], atol=3)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_diagnosis(
    different: pid.Diagnosis, estimate: pid.Estimate, changed: list[pid.Recording]
) -> None:
    again = pid.diagnose_motion(estimate, changed)
    assert json.dumps(again.as_dict()) == json.dumps(different.as_dict())


def test_a_mixture_of_fitted_and_new_recordings_is_refused(
    estimate: pid.Estimate, clean: list[pid.Recording], changed: list[pid.Recording]
) -> None:
    with pytest.raises(pid.InputError, match="fitted"):
        pid.diagnose_motion(estimate, [clean[0], changed[0]])
    with pytest.raises(pid.InputError, match="no recordings"):
        pid.diagnose_motion(estimate, [])
    with pytest.raises(pid.InputError, match="holdout"):
        pid.diagnose_motion(estimate, changed, holdout=changed[:1])


def test_a_holdout_cut_out_of_a_diagnosed_recording_is_refused(
    estimate: pid.Estimate, changed: list[pid.Recording], tmp_path: Path
) -> None:
    lines = Path(str(changed[0].source)).read_text(encoding="utf-8").splitlines(keepends=True)
    part = tmp_path / "part.csv"
    part.write_text("".join([lines[0], *lines[len(lines) // 2 :]]), encoding="utf-8")
    with pytest.raises(pid.InputError, match=r"part.csv: 100 % of its samples are those of"):
        pid.diagnose_motion(estimate, changed[:1], holdout=part)


def test_currents_without_gains_are_refused(estimate: pid.Estimate, clean: list[pid.Recording]) -> None:
    current = replace(clean[2], effort_kind="current")
    with pytest.raises(pid.InputError, match="drive gains"):
        pid.diagnose_motion(estimate, [current])


@pytest.mark.slow
def test_the_command_writes_json_and_the_extended_model(
    estimate: pid.Estimate, changed: list[pid.Recording], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, out, report = (tmp_path / name for name in ("model.json", "extended.json", "diagnosis.json"))
    estimate.save(model)
    arguments = ["diagnose", "--model", str(model), "--json", str(report), "--out", str(out)]
    assert run([*arguments, changed[0].source, "--holdout", changed[1].source]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("what is different from when the model was identified: ")
    assert len(printed.splitlines()) < 50
    data = json.loads(report.read_text())
    assert data["schema"] == "physident.diagnosis/1"
    assert [r["role"] for r in data["recordings"]] == ["diagnosed", "holdout"]
    assert data["findings"][0]["effect"] in {"load_dependent_friction", "coulomb_friction"}
    assert data["score"]["after"]["rms"][1] < 0.5 * data["score"]["before"]["rms"][1]
    assert pid.load_estimate(out).model.columns[-1].effect in {"load_dependent_friction", "payload"}


@pytest.mark.slow
def test_nothing_found_writes_no_model(
    estimate: pid.Estimate, clean: list[pid.Recording], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, out = tmp_path / "model.json", tmp_path / "extended.json"
    estimate.save(model)
    assert run(["diagnose", "--model", str(model), "--out", str(out), clean[2].source]) == 0
    assert not out.exists()
    assert "nothing" in capsys.readouterr().out
