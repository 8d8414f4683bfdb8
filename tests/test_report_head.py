"""The head of a report: its date, one sentence of what to do for each cause, and the arm with the joints of each cause."""

from __future__ import annotations

import json
import shutil
from datetime import date
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.result.findings import Verdict
from physident.effects.classification import Family
from physident.graphics.style import effect_colour
from physident.report.sections import practice as sentences
from physident.report.sections.arm import RADIUS, _places, arm_picture
from physident.report.sections.practice import WITHOUT_CAUSE, practice
from tests.page import Element, read_page
from tests.test_report import made


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, ur5: pid.Robot) -> Path:
    """A diagnosis of a recording whose joint 2 rubs the harder the more it carries."""
    folder = tmp_path_factory.mktemp("head")
    run = pid.load_recording(made(ur5, folder / "one.csv", 0))
    pid.diagnose(pid.identify(ur5, run), run).save(folder / "diagnosis.json")
    return folder


def page(diagnosis: Path) -> Element:
    out = diagnosis.parent / "report.html"
    pid.write_report(diagnosis, out)
    return read_page(out.read_text(encoding="utf-8"))


def circles(element: Element, colour: str) -> list[Element]:
    return [one for one in element.all("circle") if one.attributes["fill"] == colour]


def test_the_head_has_the_date_and_what_to_do(folder: Path) -> None:
    (head,) = page(folder / "diagnosis.json").all("header")
    today = date.today()
    assert f"{today.day} {today:%B %Y}" in head.text
    (item,) = head.all("ul", "practice")[0].all("li")
    assert item.text == f"Load-dependent friction on joint 2. {practice('load_dependent_friction')}"


def test_the_joints_of_a_cause_are_marked_and_no_other(folder: Path) -> None:
    (arm,) = page(folder / "diagnosis.json").all("div", "arm")
    (ring,) = circles(arm, effect_colour("load_dependent_friction"))
    labels = {text.text: text for text in arm.all("text")}
    assert set(labels) == {str(j) for j in range(1, 7)}
    assert [name for name, text in labels.items() if text.attributes["class"] == "marked"] == ["2"]
    assert ring.attributes["cx"] == labels["2"].attributes["x"]
    places = np.array([[float(t.attributes["x"]), float(t.attributes["y"])] for t in labels.values()])
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)[np.triu_indices(6, 1)]
    assert apart.min() > RADIUS  # no number hides another


def test_an_arm_is_drawn_without_recordings_and_a_cause_of_the_whole_arm_marks_the_tool(
    ur5: pid.Robot, folder: Path
) -> None:
    from dataclasses import replace

    from physident.diagnosis.result.saved import read_diagnosis

    c = read_diagnosis(folder / "diagnosis.json")
    whole = replace(c, findings=tuple(replace(f, effect="payload", joints=()) for f in c.findings))
    arm = read_page(arm_picture(whole, ()))
    assert len(circles(arm, effect_colour("payload"))) == 1
    assert not [text for text in arm.all("text") if text.attributes["class"] == "marked"]


def test_a_report_finds_recordings_that_were_moved_with_the_diagnosis(folder: Path, tmp_path: Path) -> None:
    for name in ("one.csv", "diagnosis.json"):
        shutil.copy(folder / name, tmp_path / name)
    hidden = (folder / "one.csv").rename(folder / "elsewhere.csv")
    try:
        assert page(tmp_path / "diagnosis.json").all("div", "chart")
        (tmp_path / "one.csv").unlink()
        lost = page(tmp_path / "diagnosis.json")
        assert not lost.all("div", "chart")
        assert "Curves are missing of one.csv (not found)." in lost.text
    finally:
        hidden.rename(folder / "one.csv")


def test_every_effect_has_a_sentence_of_what_to_do() -> None:
    learned = {name for name, effect in pid.CATALOGUE.items() if effect.family.value == "learned"}
    assert set(sentences.EFFECTS) == set(pid.CATALOGUE) - learned
    texts = [practice(name) for name in pid.CATALOGUE] + list(sentences.FAMILIES.values())
    assert all(text.endswith(".") and ": " in text for text in texts)
    assert {family for family in Family if family.value != "learned"} == set(sentences.FAMILIES)


def test_joints_at_one_place_share_a_circle() -> None:
    joints = np.array([[0.0, 0.0], [0.5, 0.0], [4 * RADIUS, 0.0], [0.0, 0.4 * RADIUS]])
    assert _places(joints) == [[1, 2, 4], [3]]


def test_every_verdict_without_a_cause_says_what_to_do(folder: Path, tmp_path: Path) -> None:
    assert set(WITHOUT_CAUSE) == set(get_args(Verdict))
    data = json.loads((folder / "diagnosis.json").read_text())
    for finding in data["findings"]:
        finding["grade"] = "hint"  # which the extended model does not carry
    saved = tmp_path / "diagnosis.json"
    saved.write_text(json.dumps(data | {"verdict": "unexplained", "extended_model": None}))
    shown = page(saved)
    (head,) = shown.all("header")
    assert WITHOUT_CAUSE["unexplained"] in head.text
    assert "not certain enough to be added to the model" in head.text
    assert not [bars for bars in shown.all("div", "bars") if len(bars.all("i")) != 1]  # there is no extended model


@pytest.mark.parametrize(("usual", "mark"), [(1.4, "nothing has changed"), (8.0, "no change was found")])
def test_no_report_is_marked_as_good_where_a_change_may_hide(
    usual: float, mark: str, folder: Path, tmp_path: Path
) -> None:
    data = json.loads((folder / "diagnosis.json").read_text())
    longer = {"memory": 1.0, "white_memory": 0.1, "times_own": 1.2, "usual_times": usual}
    data |= {"question": "different", "verdict": "nothing_missing", "findings": [], "extended_model": None}
    data["unexplained"] = [one | longer for one in data["unexplained"]]
    saved = tmp_path / "diagnosis.json"
    saved.write_text(json.dumps(data))
    (head,) = page(saved).all("header")
    assert mark in head.text
    assert ("cannot rule one out" in head.text) is (mark == "no change was found")
    assert ("nothing needs to be done" in head.text) is (mark == "nothing has changed")


def test_a_contribution_alone_is_not_the_whole_answer(folder: Path, tmp_path: Path) -> None:
    """What is proved and takes little of the error is kept, and the page asks for the temperature that would say more."""
    data = json.loads((folder / "diagnosis.json").read_text())
    (finding,) = data["findings"]
    finding["grade"] = "contribution"
    differs = {"rms": 9.0, "memory": 1.0, "white_memory": 0.1, "friction_between": {"share": 0.4, "percent": 3.68}}
    data["unexplained"] = [one | (differs if one["joint"] == 2 else {}) for one in data["unexplained"]]
    saved = tmp_path / "diagnosis.json"
    saved.write_text(json.dumps(data | {"verdict": "unexplained"}))
    shown = page(saved)
    (mark,) = shown.all("header")[0].all("p", "mark")
    assert mark.text.endswith("mostly unexplained")
    assert "What is left beside it" in shown.text
    assert "on joint 2 by up to 3.7 %: record temperature_1.." in shown.text


def test_what_is_plain_friction_by_another_name_asks_for_no_more() -> None:
    assert practice("presliding_hysteresis", ["coulomb_friction"]) == practice("coulomb_friction")
    assert (
        practice("torque_constant", ["coulomb_friction"]) == practice("torque_constant") != practice("coulomb_friction")
    )
