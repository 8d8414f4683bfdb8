"""A diagnosis in a session: its models beside those given, its findings in words."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.result.findings import Finding, JointErrors, ParameterValue, Reduction, Rival, Unseen
from physident.diagnosis.result.record import DiagnosisRecord
from physident.effects.contact import Contact
from physident.graphics.plan import plan_markdown, plan_of
from physident.graphics.session.content import compose
from physident.graphics.session.text import findings

LEVELS = JointErrors(np.ones(6), np.full(6, 10.0))
VALUE = ParameterValue(
    name="load_dependent_friction",
    joint=2,
    value=0.0814,
    change=0.0814,
    std=0.004,
    interval95=(0.0731, 0.0897),
    change_interval95=(0.0731, 0.0897),
    unit="1",
)
FOUND = Finding(
    effect="load_dependent_friction", joints=(2,), parameters=(VALUE,),
    gain=Reduction(rms_before=1.83, rms_after=0.79, reduction_percent=56.8, interval95=(51.2, 61.9)),
    rivals=(Rival("torque_constant", (3,)),), intervals=(), advice="vary the load at one speed", evidence=40.0,
)  # fmt: skip
TOUCH = Finding(
    effect="contact", joints=(), parameters=(), rivals=(), intervals=((3.5, 4.25),), advice="", evidence=9.0,
    gain=Reduction(rms_before=1.0, rms_after=0.5, reduction_percent=50.0, interval95=(40.0, 60.0)),
)  # fmt: skip


@pytest.fixture
def model(ur5: pid.Robot) -> pid.Model:
    return pid.Model.nominal(ur5)


@pytest.fixture
def diagnosis(model: pid.Model) -> DiagnosisRecord:
    extended = pid.Model(model.robot, (*model.effects, Contact()), np.append(model.theta, [1.0, 2.0, 3.0]))
    return DiagnosisRecord(
        path=None, sha256=None, question="missing", verdict="partly_explained", findings=(FOUND, TOUCH), before=LEVELS,
        after=LEVELS, scored_on="holdout", noise_floor=None, placebos=(), unseen=(Unseen("joint_spring", (5,), "of a joint that does not move"),),
        unexplained=(), recordings=(), filter=pid.Filter(7.0), layout=None, drive_gains=None, unidentified=(), model=model,
        extended=extended, incomplete=(), seed=0, recording_offsets=False,
    )  # fmt: skip


def test_the_words_have_every_number_of_a_finding(diagnosis: DiagnosisRecord) -> None:
    text = findings(diagnosis)
    for said in (
        "load-dependent friction on joint 2", "1.83 → 0.79", "57 % less", "51 to 62 %", "0.0814", "0.0731 to 0.0897",
        "torque constant on joint 3", "Vary the load at one speed", "3.5 to 4.2", "joint spring on joint 5",
    ):  # fmt: skip
        assert said in text, said
    assert text.startswith("# The model lacks load-dependent friction on joint 2")


def test_the_words_say_what_is_no_cause_and_what_was_missing_before(diagnosis: DiagnosisRecord) -> None:
    hint = replace(
        FOUND, grade="hint", stability=0.15, doubts=("found in 3 of 20 searches on halves of the recordings",)
    )
    text = findings(replace(diagnosis, findings=(TOUCH, hint), missing_since_before=(FOUND,)))
    assert "## 2. load-dependent friction on joint 2 (hint)" in text
    assert "A hint, no cause: found in 3 of 20 searches" in text
    assert "(hint)" not in text.split("## 2.")[0]
    assert (
        "**Missing since before**, as the model's own recordings show, or differ by as much: load-dependent friction on joint 2."
        in text
    )


def test_models_of_a_diagnosis_are_shown_once(diagnosis: DiagnosisRecord, model: pid.Model) -> None:
    assert diagnosis.extended is not None
    alone = compose({}, [], diagnosis, None, None)
    assert list(alone.models) == ["model as it was", "extended model"]
    assert alone.filter.cutoff == 7.0
    estimate: Any = type("E", (), {"model": model, "filter": pid.Filter(3.0), "drive_gains": None, "layout": None})()
    both = compose({"mine": estimate}, [], diagnosis, None, None)
    assert list(both.models) == ["model as it was", "extended model"]  # the diagnosed one is known by its numbers
    assert both.filter.cutoff == 3.0
    assert compose({"mine": estimate}, [], diagnosis, None, 6.0).filter.cutoff == 6.0


def test_a_diagnosis_of_another_arm_is_refused(diagnosis: DiagnosisRecord, model: pid.Model) -> None:
    other = pid.Model(pid.Robot("other", model.robot.urdf), model.effects, model.theta)
    estimate: Any = type("E", (), {"model": other, "filter": pid.Filter(), "drive_gains": None, "layout": None})()
    with pytest.raises(pid.InputError, match="the diagnosis is of robot ur5, model mine is of other"):
        compose({"mine": estimate}, [], diagnosis, None, None)
    moved: Any = type("E", (), {**vars(type(estimate)), "model": replace(model, theta=model.theta * 1.01)})()
    assert list(compose({"mine": moved}, [], diagnosis, None, None).models) == [
        "model as it was",
        "mine",
        "extended model",
    ]


def test_a_design_is_read_back_with_its_limits(tmp_path: Any, ur5: pid.Robot) -> None:
    import json

    motion = pid.random_trajectory(ur5, seed=4)
    margin = {"limit": "speed", "where": "joint 3", "reached": 3.1, "allowed": 3.2, "margin": 0.1, "unit": "rad/s"}
    far = margin | {"where": "joint 4", "reached": 1.0, "margin": 2.2}
    design = {
        "schema": "physident.design/1", "criterion": "condition", "condition": 14.25, "columns": 36,
        "weighting": "unscaled", "margins": [far, margin], "trajectory": motion.as_dict(), "progress": [90.0, 14.25],
    }  # fmt: skip
    path = tmp_path / "design.json"
    path.write_text(json.dumps(design))
    plan = plan_of(path)
    np.testing.assert_array_equal(plan.motion.sample(20.0)[1], motion.sample(20.0)[1])
    assert plan.progress == (90.0, 14.25)
    words = plan_markdown(plan.design)
    assert "14.25" in words
    assert words.index("joint 3") < words.index("joint 4")  # the nearest limit first
    for broken in ({"margins": [{}]}, {"condition": "high"}, {"progress": [1.0, -2.0]}, {"trajectory": {"a": 1}}):
        path.write_text(json.dumps(design | broken))
        with pytest.raises(pid.InputError, match=r"design\.json"):
            plan_of(path)
