"""Results in a notebook: their tables hold the numbers of the results, and no text of a user becomes markup."""

from __future__ import annotations

from html.parser import HTMLParser
from typing import Any

import pytest

import physident as pid
from physident.notebook import results_html
from tests.test_report import made

EFFECTS = ("rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction", "torque_offset")


class Table(HTMLParser):
    """The cells of the body of a table, row by row, and all text."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.text, self.tags, self._inside = "", set[str](), False
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self._inside = tag == "td"
        if tag == "tr":
            self.rows.append([])
        elif tag == "td":
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        self._inside = False

    def handle_data(self, data: str) -> None:
        self.text += data
        if self._inside:
            self.rows[-1][-1] += data


def table(result: Any) -> Table:
    """What a notebook shows of a result, without the row of headings."""
    shown = Table(result._repr_html_())
    assert shown.tags <= {"div", "p", "strong", "table", "thead", "tbody", "tr", "th", "td"}
    shown.rows = [row for row in shown.rows if row]
    return shown


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory, ur5: pid.Robot) -> list[pid.Recording]:
    """Two recordings with load-dependent friction on joint 2."""
    folder = tmp_path_factory.mktemp("notebook")
    return [pid.load_recording(made(ur5, folder / f"{seed}.csv", seed)) for seed in (0, 1)]


@pytest.fixture(scope="module")
def estimate(ur5: pid.Robot, runs: list[pid.Recording]) -> pid.Estimate:
    return pid.identify(ur5, runs[0])


def test_a_recording_shows_its_ranges(runs: list[pid.Recording]) -> None:
    rows = table(runs[0]).rows
    assert len(rows) == 6
    assert float(rows[2][1]) == pytest.approx(runs[0].q[:, 2].min(), rel=1e-3)
    assert float(rows[5][5]) == pytest.approx(runs[0].effort[:, 5].max(), rel=1e-3)


def test_an_estimate_shows_its_values_with_standard_errors(estimate: pid.Estimate) -> None:
    shown = table(estimate)
    cells = " ".join(shown.rows[3])
    assert f"{estimate['viscous_friction_4']:.4g} ±" in cells
    assert "verdict" in shown.text


def test_scores_and_gains_show_each_joint(estimate: pid.Estimate, runs: list[pid.Recording], ur5: pid.Robot) -> None:
    score = pid.validate(estimate, runs[1])
    assert [float(row[1]) for row in table(score).rows] == pytest.approx(list(score.rms), rel=1e-3)
    better = pid.identify(ur5, runs[0], effects=[*EFFECTS, "load_dependent_friction"])
    gain = pid.compare(estimate, better, on=runs[1])
    assert [float(row[-1]) for row in table(gain).rows] == pytest.approx(list(gain.reduction), abs=0.06)
    assert "verdict: the second model is" in table(gain).text


@pytest.mark.slow
def test_a_diagnosis_shows_its_findings_and_is_a_frame(estimate: pid.Estimate, runs: list[pid.Recording]) -> None:
    pytest.importorskip("pandas", reason="pandas is not installed")
    diagnosis = pid.diagnose_motion(estimate, [runs[0]])
    shown, frame = table(diagnosis), diagnosis.to_frame()
    assert len(shown.rows) == len(diagnosis.findings) > 0
    assert shown.rows[0][0] == diagnosis.findings[0].effect == "load_dependent_friction"
    assert len(frame) == sum(len(f.parameters) for f in diagnosis.findings)
    first = frame.iloc[0]
    assert first["low"] < first["value"] < first["high"]
    assert first["joint"] == 2
    complete = pid.identify(estimate.model.robot, runs[0], effects=[*EFFECTS, "load_dependent_friction"])
    nothing = pid.diagnose_motion(complete, [runs[0]])
    assert not nothing.findings
    assert list(nothing.to_frame().columns) == list(frame.columns)


@pytest.mark.slow
def test_a_design_shows_its_margins(ur5: pid.Robot) -> None:
    design = pid.design_trajectory(ur5, seed=1, limits="joint")
    rows = table(design).rows
    assert len(rows) == len(design.margins)
    assert rows[0][0] == design.margins[0].limit


def test_text_of_a_user_is_no_markup() -> None:
    html = results_html("<script>alert(1)</script>", ["<b>"], [["<img src=x>"]], "a & b")
    assert Table(html).tags.isdisjoint({"script", "img", "b"})
    assert "a & b" in Table(html).text


def test_a_table_without_rows_is_its_sentences() -> None:
    assert "table" not in Table(results_html("title", ["a"], [], "note")).tags
