"""The report says what the diagnosis found, to people, and nothing that a file could have made it say."""

from __future__ import annotations

import copy
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.cli import run
from tests.page import Element, read_page

MU = 0.08
COULOMB, VISCOUS = np.array([5, 5, 4, 1, 1, 1]), np.array([8, 8, 5, 2, 2, 1.5])
NOISE = np.array([0.5, 0.5, 0.4, 0.1, 0.1, 0.1])


def made(robot: pid.Robot, path: Path, seed: int) -> Path:
    """A recording whose joint 2 rubs the harder the more it carries: Pinocchio and closed forms, no effect of the package."""
    time, q, v, a = pid.random_trajectory(robot, seed=seed, duration=20.0).sample(100.0)
    data = robot.pinocchio.createData()
    load = np.array([pin.rnea(robot.pinocchio, data, *s).copy() for s in zip(q, v, a, strict=True)])
    rub = np.tanh(v / 0.01)
    torque = load + COULOMB * rub + VISCOUS * v
    torque[:, 1] += MU * rub[:, 1] * np.abs(load[:, 1])
    torque += NOISE * np.random.default_rng(seed).normal(size=torque.shape)
    names = ["time", *(f"{k}_{j}" for k in ("q", "dq", "tau") for j in range(1, 7))]
    rows = np.column_stack([time, q, v, torque])
    np.savetxt(path, rows, "%.10g", ",", header=",".join(names), comments="")
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, ur5: pid.Robot) -> Path:
    """Two recordings, the model of one, and its diagnosis judged on the other."""
    folder = tmp_path_factory.mktemp("case")
    one, two = (made(ur5, folder / f"{name}.csv", seed) for seed, name in enumerate(("one", "two")))
    estimate = pid.identify(ur5, pid.load_recordings(one))
    found = pid.diagnose_motion(estimate, pid.load_recordings(one), pid.load_recordings(two))
    found.save(folder / "diagnosis.json")
    return folder


def page_of(folder: Path, edit: Callable[[dict[str, Any]], object] = lambda _: None) -> Element:
    """The page of the fixture's diagnosis after an edit of its JSON."""
    data = json.loads((folder / "diagnosis.json").read_text())
    edit(data)
    changed = folder / "changed.json"
    changed.write_text(json.dumps(data))
    pid.write_report(changed, folder / "changed.html")
    return read_page((folder / "changed.html").read_text(encoding="utf-8"))


def test_what_the_model_lacked_before_stands_apart_from_what_has_changed(folder: Path) -> None:
    def as_old(data: dict[str, Any]) -> None:
        data["missing_since_before"] = data["findings"]

    title = "What the model lacked before, too"
    page, without = page_of(folder, as_old), page_of(folder)
    (section,) = [one for one in page.all("section") if one.all("h2")[0].text == title]
    assert [item.text for item in section.all("li")] == ["Load-dependent friction on joint 2"]
    assert title not in without.text
    counted = "holds what the model lacked before, too."
    assert counted in page.all("header")[0].text
    assert counted not in without.text


def test_the_answer_comes_first_and_numbers_are_those_of_the_diagnosis(folder: Path) -> None:
    page, data = page_of(folder), json.loads((folder / "diagnosis.json").read_text())
    (head,) = page.all("h1")
    assert head.text == "The model lacks load-dependent friction on joint 2."
    order = [element.name for element in page.all("main")[0].inside if isinstance(element, Element)]
    assert order[0] == "header"
    rows = page.all("div", "level")
    assert len(rows) == 6
    for j, row in enumerate(rows):
        sizes = [data["score"][key]["rms"][j] for key in ("before", "after")]
        shown = re.search(r"([\d.]+) → ([\d.]+) N m RMS", row.text)
        assert shown, row.text
        np.testing.assert_allclose([float(x) for x in shown.groups()], sizes, rtol=6e-3)
        widths = [float(re.findall(r"width:([\d.]+)%", bar.attributes["style"])[0]) for bar in row.all("i")]
        relative = [data["score"][key]["relative_percent_all"][j] for key in ("before", "after")]
        assert widths[0] / widths[1] == pytest.approx(relative[0] / relative[1], rel=0.01)
    (card,) = page.all("article")
    (value,) = data["findings"][0]["parameters"]
    cells = [cell.text for cell in card.all("td")]
    assert float(cells[2]) == pytest.approx(value["value"], rel=6e-3)
    low, high = (float(x) for x in cells[3].split(" to "))
    assert (low, high) == pytest.approx(tuple(value["interval95"]), rel=6e-3)
    assert low < MU < high


def test_the_page_needs_nothing_from_outside_and_runs_nothing(folder: Path) -> None:
    page = page_of(folder)
    allowed = {"default-src 'none'; style-src 'unsafe-inline'"}
    assert {m.attributes["content"] for m in page.all("meta") if "http-equiv" in m.attributes} == allowed
    html = (folder / "changed.html").read_text(encoding="utf-8")
    assert not page.all("script")
    assert not page.all("link")
    assert not re.findall(r"https?:|url\(|\bsrc=|\bhref=|@import", html)


def test_curves_are_the_torque_that_was_measured_and_what_each_model_leaves(folder: Path) -> None:
    """The curves of joint 2, brought back from the drawing, against the recording and its residuals."""
    figure = page_of(folder).all("figure")[1]
    torque, residual = (chart.all("polyline") for chart in figure.all("div", "chart"))
    assert (len(torque), len(residual)) == (3, 2)
    measured, before, after = (heights(line) for line in torque)
    axis = scale(figure.all("div", "chart")[0])
    left = scale(figure.all("div", "chart")[1])
    first, second = (heights(line) for line in residual)
    # what is drawn below is the difference of what is drawn above, to the resolution of either
    tolerance = 2 * (abs(axis[1]) + abs(left[1]))
    for model, rest in ((before, first), (after, second)):
        difference = axis[1] * (measured - model)
        np.testing.assert_allclose(left[0] + left[1] * rest, difference, atol=tolerance)
    recording = pid.load_recording(folder / "two.csv")
    then = times(figure.all("div", "chart")[0], torque[0])
    raw = np.interp(then, recording.time - recording.time[0], recording.torque[:, 1])
    drawn = axis[0] + axis[1] * measured
    assert np.linalg.norm(drawn - raw) < 0.1 * np.linalg.norm(raw)  # noise and the filter's smoothing; no shift in time
    sizes = [np.sqrt(np.mean((left[0] + left[1] * x) ** 2)) for x in (first, second)]
    score = json.loads((folder / "diagnosis.json").read_text())["score"]
    expected = [score[key]["rms"][1] for key in ("before", "after")]
    np.testing.assert_allclose(sizes, expected, rtol=0.02)


def heights(line: Element) -> np.ndarray:
    """The heights (N,) of a curve in units of the drawing."""
    return np.array([float(point.split(",")[1]) for point in line.attributes["points"].split()])


def times(chart: Element, line: Element) -> np.ndarray:
    """The times (N,) [s] of a curve, by the labels of the axis."""
    (columns,) = chart.all("div", "columns")
    labels = [
        (float(re.findall(r"left:([\d.]+)%", s.attributes["style"])[0]), float(s.text)) for s in columns.all("span")
    ]
    place, second = np.array(labels).T
    slope, offset = np.polyfit(place, second, 1)
    x = np.array([float(point.split(",")[0]) for point in line.attributes["points"].split()])
    return offset + slope * x / 20  # of the drawing's 2000, in percent


def scale(chart: Element) -> tuple[float, float]:
    """Offset and slope from heights to values, by the labels of the axis."""
    (rows,) = chart.all("div", "rows")
    labels = [(span.attributes["style"], span.text.replace("−", "-")) for span in rows.all("span")]
    points = [(10 * float(re.findall(r"top:([\d.-]+)%", style)[0]), float(text)) for style, text in labels]
    height, value = np.array(points).T
    slope, offset = np.polyfit(height, value, 1)
    return float(offset), float(slope)


def test_recordings_are_drawn_only_with_the_hash_that_was_diagnosed(folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "diagnosis.json", tmp_path / "diagnosis.json")
    for name in ("one.csv", "two.csv"):
        shutil.copy(folder / name, tmp_path / name)

    def moved(data: dict[str, Any]) -> None:
        for used in data["recordings"]:
            used["path"] = Path(used["path"]).name

    # relative paths are found beside the diagnosis
    assert len(page_of(tmp_path, moved).all("figure")) == 6
    text = (tmp_path / "two.csv").read_text().splitlines()
    last = text[-1].split(",")
    (tmp_path / "two.csv").write_text("\n".join([*text[:-1], ",".join([*last[:-1], "0.123"])]) + "\n")
    page = page_of(tmp_path, moved)
    assert "Curves are missing of two.csv (changed:" in page.text
    assert [h.text for h in page.all("h3")].count("one.csv") == 1
    (tmp_path / "two.csv").unlink()
    (tmp_path / "one.csv").write_text("no recording")
    page = page_of(tmp_path, moved)
    assert not page.all("div", "chart")
    assert "No torque is drawn: none of the recordings could be read again." in page.text
    assert "Curves are missing of one.csv (cannot be read again" in page.text
    assert "two.csv (not found)." in page.text


def test_a_model_that_lacked_structure_before_is_said_to(folder: Path, tmp_path: Path) -> None:
    for name in ("one.csv", "two.csv", "diagnosis.json"):
        shutil.copy(folder / name, tmp_path / name)
    assert "Changes that may not be new" not in page_of(tmp_path, lambda data: data.update(incomplete=[])).text
    page = page_of(tmp_path, lambda data: data.update(incomplete=[2, 3]))
    assert "is still autocorrelated on joints 2 and 3" in page.text
    assert "First find what the model lacks" in page.text


def test_every_rival_has_the_command_that_can_be_typed(folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "diagnosis.json", tmp_path / "diagnosis.json")

    def doubted(data: dict[str, Any]) -> None:
        finding = data["findings"][0]
        assert finding["joints"]
        data["seed"], data["recording_offsets"] = 12, True
        finding["rivals"] = [{"effect": name, "joints": finding["joints"]} for name in ("warm_up", "torque_ripple")]

    name = json.loads((folder / "diagnosis.json").read_text())["findings"][0]["effect"]
    text = page_of(tmp_path, doubted).text
    for rival in ("warm_up", "torque_ripple"):
        assert f"--discriminate {name} {rival} --joint" in text
    assert "--recording-offsets --seed 12 --json" in text


def test_names_cannot_become_markup(folder: Path, tmp_path: Path) -> None:
    bad = '"><script>alert(1)<script>&amp;<img src=x onerror=alert(2)>.csv'
    shutil.copy(folder / "two.csv", tmp_path / bad)
    shutil.copy(folder / "diagnosis.json", tmp_path / "diagnosis.json")

    def renamed(data: dict[str, Any]) -> None:
        data["recordings"][1]["path"] = bad
        data["recordings"][0]["path"] = "\u202egnp.exe\x1b[31m\udc80"
        data["held"] = ["<b>m_1</b>"]
        for key in ("model", "extended_model"):
            robot = data[key]["robot"]
            robot["name"] = "<u>arm</u>"
            robot["urdf"] = robot["urdf"].replace("shoulder_pan_joint", "&lt;svg onload=alert(3)&gt;")

    page = page_of(tmp_path, renamed)
    assert not page.all("script")
    assert not page.all("img")
    assert {e.attributes["role"] for e in page.all("svg")} == {"img"}  # ours alone
    assert all("onload" not in e.attributes for e in page.all("svg"))
    for text in (bad, "<b>m_1</b>", "<u>arm</u>", "<svg onload=alert(3)>"):
        assert text in page.text
    html = (tmp_path / "changed.html").read_text(encoding="utf-8")
    assert not set(html) & {"\u202e", "\x00", "\x1b", "\udc80"}


@pytest.mark.parametrize(
    ("verdict", "head", "lead"),
    [
        ("nothing_missing", "Nothing is missing from the model", "the remaining residual is noise"),
        (
            "unexplained",
            "These recordings prove nothing that is missing from the model, and do not",
            "The residual has structure",
        ),
    ],
)
def test_no_finding_is_said_in_words_and_claims_no_gain(folder: Path, verdict: str, head: str, lead: str) -> None:
    page = page_of(folder, lambda data: data.update(verdict=verdict, findings=[], extended_model=None))
    (title,) = page.all("h1")
    assert title.text.startswith(head)
    assert lead in page.all("header")[0].text
    assert "extended model" not in page.text
    assert not page.all("article")
    assert all(len(chart.all("polyline")) == 1 for chart in page.all("div", "chart")[1::2])


def test_a_joint_that_errs_more_than_before_is_named_though_nothing_describes_it(folder: Path) -> None:
    def grown(data: dict[str, Any]) -> None:
        data.update(findings=[], extended_model=None, verdict="unexplained", question="different")
        slow = data["unexplained"][1]
        burst = {"recording": "one.csv", "start": 3.0, "end": 5.0, "share": 0.9, "of_time": 0.1, "at_rest": False}
        slow.update(memory=100 * slow["white_memory"], times_own=6.5, bursts=[burst])
        for one in data["unexplained"]:
            one.setdefault("times_own", 1.0)
        data["score"]["noise_floor"] = None
        data["recordings"][0]["repeats"] = "before.csv"

    page = page_of(folder, grown)
    assert "Joint 2 errs 6.5 times as much as on the model's own recordings" in page.all("h1")[0].text
    assert "Look at joint 2 at the times that stand under “What could not be seen”." in page.all("header")[0].text
    assert "90 % of it lies between 3.0 and 5.0 s of one.csv" in page.text
    assert "No motion was repeated here" not in page.text


@pytest.mark.parametrize(
    ("times", "means"),
    [
        (1.01, "distrust what has no more evidence: load-dependent friction on joint 2"),
        (0.99, "all that was found has more"),
    ],
)
def test_a_placebo_that_passed_and_a_rival_are_said_before_anything_else(
    folder: Path, times: float, means: str
) -> None:
    """It casts doubt on what has no more evidence, and on nothing else."""

    def doubtful(data: dict[str, Any]) -> None:
        data["placebos"][0].update(gain=times * data["findings"][0]["evidence"], passed=True)
        data["findings"][0]["rivals"] = [{"effect": "torque_constant", "joints": [2]}]

    page = page_of(folder, doubtful)
    (head,) = page.all("header")
    assert means in head.text
    assert "Finding 1 could have another cause" in head.text
    assert "It could also be torque constant on joint 2." in page.all("article")[0].text
    assert "To separate load-dependent friction on joint 2 from torque constant on joint 2" in page.text
    calm = page_of(folder).all("header")[0]
    assert "Note:" not in calm.text


def test_a_shape_of_which_nothing_is_known_has_no_value(folder: Path) -> None:
    def wide(data: dict[str, Any]) -> None:
        (size,) = data["findings"][0]["parameters"]
        shape = {**size, "name": "distance", "value": 0.013, "unit": "rad", "interval95": [2e-11, 7e6]}
        data["findings"][0]["parameters"].append({**shape, "change": 0.013, "change_interval95": [2e-11, 7e6]})

    rows = cells(page_of(folder, wide))
    assert rows["distance"] == ["2", "not known", ""]
    assert float(rows["load-dependent friction"][1]) == pytest.approx(MU, rel=0.05)


def test_evidence_is_drawn_in_units_of_each_threshold(folder: Path) -> None:
    def known(data: dict[str, Any]) -> None:
        for placebo in data["placebos"]:
            placebo.update(gain=-1.0, threshold=50.0)
        data["placebos"][3].update(gain=24.5, threshold=50.0)
        data["findings"][0].update(evidence=400.0, threshold=25.0)

    def of_before(data: dict[str, Any]) -> None:
        known(data)
        del data["findings"][0]["threshold"]

    page = page_of(folder, known)
    (drawn,) = page.all("div", "scale")
    places = {
        name: [float(re.findall(r"left:([\d.]+)%", one.attributes["style"])[0]) for one in drawn.all(name)]
        for name in ("i", "u", "b")
    }
    ((finding,), (threshold,), placebos) = places.values()
    zero = min(placebos)  # of those that explain less than nothing
    assert threshold - zero == pytest.approx((finding - zero) / 4, abs=0.1)
    assert max(placebos) - zero == pytest.approx(0.7 * (threshold - zero), abs=0.1)
    assert cells(page)["load-dependent friction on joint 2"] == ["400", "25.0", "16"]
    assert cells(page)["nearest of 12 placebos (0 above the threshold)"] == ["24.5", "50.0", "0.49"]
    before = page_of(folder, of_before)
    assert not before.all("div", "scale")[0].all("i")
    assert cells(before)["load-dependent friction on joint 2"] == ["400", "–", "–"]


def cells(page: Element) -> dict[str, list[str]]:
    """The rows of tables of numbers, by what stands first in them."""
    rows = (row for table in page.all("table", "numbers") for body in table.all("tbody") for row in body.all("tr"))
    texts = [[cell.text for cell in row.all("td")] for row in rows]
    return {first: rest for first, *rest in texts}


def test_what_does_not_repeat_is_shown_and_nothing_below_it_is_called_structure(folder: Path) -> None:
    def repeated(data: dict[str, Any]) -> None:
        data.update(verdict="partly_explained")
        for one in data["unexplained"]:
            one.update(structured=True, memory=1.0, rms=0.5)
        data["score"]["noise_floor"] = [0.6, 0.4, 0.6, 0.6, 0.6, 0.6]

    page = page_of(folder, repeated)
    assert "floor 0.400 N m" in page.all("div", "level")[1].text
    assert "No motion was repeated here" not in page.text
    rows = [row.text for row in page.all("section")[-3].all("tr") if row.text.startswith("joint")]
    assert [row[:7] for row in rows] == ["joint 2"]  # the others lie below what did not repeat


def test_a_joint_that_got_worse_is_named(folder: Path) -> None:
    def worse(data: dict[str, Any]) -> None:
        data["score"]["after"]["rms"][4] = 1.3 * data["score"]["before"]["rms"][4]

    assert "5 (by 30 %)" in page_of(folder, worse).all("header")[0].text.partition("It rises on ")[2]


def test_a_contact_is_shaded_where_it_was(folder: Path) -> None:
    def touched(data: dict[str, Any]) -> None:
        contact = {"effect": "contact", "joints": None, "intervals": [[6.0, 7.0]]}
        contact["recording"] = data["recordings"][0]["sha256"]
        names = [f"contact_F{axis}_{start}s" for start in ("6", "6.5") for axis in "xyz"]
        values = [{"name": name, "joint": 6, "unit": "N", "value": 5.0} for name in names]
        data["extended_model"]["effects"].append(contact)
        data["extended_model"]["parameters"] += values
        found = copy.deepcopy(data["findings"][0])
        found.update(effect="contact", joints=[], intervals=[[6.0, 7.0]], parameters=[])
        data["findings"] = [found]
        data["score"]["on"] = "left-out rows"

    page = page_of(folder, touched)
    assert page.all("h1")[0].text == "The tool was in contact with something from 6.00 to 7.00 s."
    counted = "Only the first of these errors holds the rows of the contact"
    assert counted in page.all("header")[0].text
    assert counted not in page_of(folder).text
    heads = [head.text for head in page.all("h3")]
    assert heads.index("one.csv") < heads.index("two.csv")  # the contact lies in the diagnosed recording
    figure = page.all("figure")[0]
    (band,) = figure.all("rect")[:1]
    ticks = [(s.attributes["style"], float(s.text)) for s in figure.all("div", "columns")[0].all("span")]
    places = np.array([(float(re.findall(r"left:([\d.]+)%", style)[0]), t) for style, t in ticks])
    start, width = (float(band.attributes[key]) / 20 for key in ("x", "width"))  # of the drawing's 2000, in percent
    ends = np.interp([start, start + width], *places.T)
    np.testing.assert_allclose(ends, [6.0, 7.0], atol=0.03)
    assert not page.all("figure")[6].all("rect")


def test_another_joint_count_and_a_sliding_joint_have_their_units(tmp_path: Path) -> None:
    urdf = tmp_path / "lift.urdf"
    urdf.write_text(
        '<robot name="lift"><link name="base"/><link name="table"><inertial><mass value="3"/><origin xyz="0 0 0.1"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
        '<joint name="up" type="prismatic"><parent link="base"/><child link="table"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="100"/></joint></robot>'
    )
    robot = pid.load_robot(str(urdf))
    recordings = []
    for seed in (0, 1):
        time, q, v, a = pid.random_trajectory(robot, seed=seed, duration=20.0).sample(100.0)
        force = 3 * (a + 9.81) + 1.5 * np.tanh(v / 0.01)
        force += 0.1 * np.random.default_rng(seed).normal(size=force.shape)
        path = tmp_path / f"{seed}.csv"
        np.savetxt(path, np.column_stack([time, q, v, force]), header="time,q_1,dq_1,tau_1", comments="", delimiter=",")
        recordings.append(pid.load_recording(path))
    found = pid.diagnose_motion(pid.Model.nominal(robot, ["rigid_body"]), recordings[:1], recordings[1:])
    pid.write_report(found, tmp_path / "report.html")
    page = read_page((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert "Coulomb friction on joint 1" in page.all("h1")[0].text
    (figure,) = page.all("figure")
    assert [title.text for title in figure.all("div", "title")] == ["torque [N]", "residual [N]"]
    assert re.search(r"→ [\d.]+ N RMS", page.all("div", "level")[0].text)
    assert "--robot ROBOT" in page.text


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        (lambda d: d.pop("findings"), "findings"),
        (lambda d: d.update(schema="physident.model/1"), "schema is 'physident.model/1'"),
        (lambda d: d["score"]["before"].update(rms=[1.0]), "expected the robot's 6"),
        (lambda d: d["score"]["before"]["rms"].__setitem__(2, float("nan")), "expected a finite number"),
        (lambda d: d["score"]["before"]["rms"].__setitem__(2, -1.0), "negative"),
        (lambda d: d["findings"][0].update(joints=[7]), "joint 7"),
        (lambda d: d["findings"][0].update(joints=["<b>"]), "expected a whole number"),
        (lambda d: d["findings"][0].update(effect="magic"), "'magic' is not in the catalogue"),
        (lambda d: d["findings"][0].pop("gain"), "has no 'gain'"),
        (lambda d: d.update(verdict="fine"), "verdict is 'fine'"),
        (lambda d: d.update(verdict="unexplained"), "do not go together"),
        (lambda d: d.update(extended_model=None), "do not go together"),
        (lambda d: d["model"].update(robot=3), "model.robot is 3, expected an object"),
        (lambda d: d["placebos"][0].update(gain="high"), "expected a finite number"),
    ],
)
def test_a_broken_diagnosis_is_one_line_and_leaves_the_page_that_was_there(
    folder: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    edit: Callable[[dict[str, Any]], object],
    said: str,
) -> None:
    data = json.loads((folder / "diagnosis.json").read_text())
    edit(data)
    broken, out = tmp_path / "broken.json", tmp_path / "report.html"
    broken.write_text(json.dumps(data))
    out.write_text("the page before")
    assert run(["report", "--diagnosis", str(broken), "--out", str(out), "--force"]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert str(broken) in printed.err
    assert said in printed.err
    assert out.read_text() == "the page before"


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, "[]", "\x00", '{"schema": "physident.diagnosis/1"}'])
def test_what_is_no_diagnosis_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str) -> None:
    path = tmp_path / "d.json"
    path.write_text(text)
    assert run(["report", "--diagnosis", str(path), "--out", str(tmp_path / "r.html")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "r.html").exists()


def test_outputs_are_checked_before_anything_is_read(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    diagnosis = str(folder / "diagnosis.json")
    for out in (diagnosis, str(folder / "report.txt"), str(folder / "none" / "report.html")):
        assert run(["report", "--diagnosis", diagnosis, "--out", out]) == 2
    assert json.loads((folder / "diagnosis.json").read_text())["schema"] == "physident.diagnosis/1"
    assert capsys.readouterr().err.count("\n") == 3


def test_where_it_comes_from_is_said_with_hashes_and_commands(folder: Path) -> None:
    import hashlib

    diagnosis, out = folder / "diagnosis.json", folder / "provenance.html"
    assert run(["report", "--diagnosis", str(diagnosis), "--out", str(out)]) == 0
    last = read_page(out.read_text(encoding="utf-8")).all("section")[-1].text
    assert hashlib.sha256(diagnosis.read_bytes()).hexdigest() in last
    for name in ("one", "two"):
        assert pid.load_recording(folder / f"{name}.csv").sha256 in last
    assert f"physident report --diagnosis {diagnosis} --out {out}" in last
    assert f"physident diagnose --model MODEL {folder / 'one.csv'} --holdout {folder / 'two.csv'}" in last
    assert f"physident {pid.__version__}" in last
