"""Model and trajectory files that an earlier version wrote still load, with the same values."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.result.saved import read_diagnosis
from physident.estimation.physical.bounds import Bound, Box, Ellipsoid

FILES = Path(__file__).parent / "files"


@pytest.fixture(scope="module")
def model() -> pid.Estimate:
    return pid.load_estimate(FILES / "model.json")


def without_leads(data: Any) -> Any:
    """JSON without the lead of viscous friction, which these files are older than; it must be none."""
    if isinstance(data, list):
        return [without_leads(one) for one in data]
    if not isinstance(data, dict):
        return data
    if data.get("effect") == "viscous_friction" and "lead" in data:
        assert data["lead"] == 0.0
        data = {key: value for key, value in data.items() if key != "lead"}
    return {key: without_leads(value) for key, value in data.items()}


def test_model_file_is_saved_as_it_was_read(model: pid.Estimate, tmp_path: Path) -> None:
    model.save(tmp_path / "again.json")
    again, original = (json.loads(path.read_text()) for path in (tmp_path / "again.json", FILES / "model.json"))
    again = without_leads(again)
    assert again.pop("information") is None  # which older files do not have
    derived = ("violations", "base_parameters")  # computed from the others
    assert {k: v for k, v in again.items() if k not in derived} == {
        k: v for k, v in original.items() if k not in derived
    }
    for new, old in zip(again["base_parameters"], original["base_parameters"], strict=True):
        assert new["value"] == pytest.approx(old["value"], abs=1e-9)


def test_settings_and_results_of_a_model_file(model: pid.Estimate) -> None:
    assert model.model.robot.n == 2
    assert [effect.name for effect in model.model.effects][-1] == "stribeck_friction"
    assert model.layout == "time=0,q=1:3,dq=3:5,current=5:7"
    assert model.drive_gains == (10.0, 8.0)
    assert model.active_constraints == ("m_2 outside its bounds",)
    assert [found.field for found in model.shape_parameters] == ["velocity", "velocity"]
    assert model.method == "physical"
    assert isinstance(model.estimator, pid.Physical)
    assert model.estimator.bounds == (Bound("m_2", 0.5, 0.95),)
    assert [type(volume) for volume in model.estimator.bounding_volumes] == [Ellipsoid, Box]
    assert model.prior_weight == 1.0
    assert model.model.parameters("coulomb_friction") == pytest.approx([1.0, 1.0], abs=0.01)
    assert "active constraints, without which: m_2 outside its bounds" in repr(model)


def test_trajectory_file() -> None:
    motion = pid.load_trajectory(FILES / "trajectory.json")
    _, q, v, _ = motion.sample(100.0)
    assert motion.n == 2
    assert motion.duration == 10.0
    np.testing.assert_allclose(v[[0, -1]], 0.0, atol=1e-9)
    assert np.ptp(q, axis=0).min() > 0.1


def test_a_diagnosis_without_the_files_of_its_models_is_read(tmp_path: Path) -> None:
    """As earlier versions wrote it."""
    text = json.loads((FILES / "diagnosis.json").read_text(encoding="utf-8"))
    del text["model_file"], text["extended_file"]
    (tmp_path / "old.json").write_text(json.dumps(text))
    assert read_diagnosis(tmp_path / "old.json").model_file is None


def test_diagnosis_file() -> None:
    text = json.loads((FILES / "diagnosis.json").read_text(encoding="utf-8"))
    record = read_diagnosis(FILES / "diagnosis.json")
    again = without_leads(json.loads(json.dumps(record.as_dict())))
    # of a file from before these were known
    assert (again.pop("missing_since_before"), again.pop("controlled"), again.pop("wrong_baseline")) == ([], None, [])
    assert again.pop("wrong_unseen") == []
    assert again.pop("headline") == record.headline
    for one in again["findings"]:
        assert (one.pop("grade"), one.pop("takes_percent"), one.pop("leaves_percent")) == ("cause", None, None)
        assert (one.pop("stability"), one.pop("doubts"), one.pop("confounder")) == (None, [], "")
        assert one.pop("threshold") is None
        assert (one.pop("in_words"), one.pop("curves"), one.pop("no_cause")) == ("", [], "")
        assert one.pop("handed_on") is True
        assert one.pop("mostly_new") is False
        for value in one["parameters"]:
            low, high = value.pop("change_interval95")
            assert high - low == pytest.approx(np.ptp(value["interval95"]))
            assert low < value["change"] < high
    for one in again["unexplained"]:
        assert (one.pop("predictable"), one.pop("friction_between")) == (None, None)
        assert one.pop("bursts") == []
        assert (one.pop("times_own"), one.pop("usual_times"), one.pop("may_hide_a_change")) == (None, None, False)
        assert (one.pop("times_noise"), one.pop("slowest"), one.pop("unproven")) == (None, 0.0, None)
    for one in again["recordings"]:
        assert one.pop("repeats") is None
    for errors in (again["score"]["before"], again["score"]["after"]):
        errors["relative_percent"] = errors.pop("relative_percent_all")
    assert again == text
    (finding,) = record.findings
    assert (finding.effect, finding.joints) == ("presliding_hysteresis", (1,))
    assert record.extended is not None
    assert record.verdict == "explained"
