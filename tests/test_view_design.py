"""A design in a session before it is recorded: its motion, its limits, and the condition number iteration by iteration."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rerun.chunk import RrdReader

import physident as pid
from physident.graphics.plan import plan_of
from physident.graphics.session.chart import HEIGHT, WIDTH
from tests.test_view_session import curve, read

RATE = 50.0  # Hz of the curves


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory, ur5: pid.Robot) -> dict[str, Any]:
    """What a quick design wrote as JSON."""
    found = pid.design_trajectory(ur5, limits="joint", seed=2, harmonics=3, starts=1, generations=4)
    path = tmp_path_factory.mktemp("design") / "design.json"
    path.write_text(json.dumps(found.as_dict(), allow_nan=False))
    return {"path": path, **json.loads(path.read_text())}


@pytest.fixture(scope="module")
def entities(written: dict[str, Any], ur5: pid.Robot) -> dict[str, dict[str, list[Any]]]:
    """Every entity of the session that shows it, and its blueprint's under "blueprint"."""
    session = written["path"].with_name("session.rrd")
    pid.view(to=session, plan=written["path"], robot=ur5)
    reader = RrdReader(session)
    return read(reader, reader.recordings()[0]) | {"blueprint": read(reader, reader.blueprints()[0])}  # pyright: ignore[reportReturnType]


def test_the_chart_shows_the_condition_number_of_every_iteration(
    written: dict[str, Any], entities: dict[str, dict[str, list[Any]]]
) -> None:
    (strip,) = entities["/design/progress/condition_number"]["LineStrips2D:strips"][0]
    drawn = np.array(strip, dtype=float)
    progress = np.array(written["progress"])
    assert len(drawn) == len(progress)
    np.testing.assert_allclose(np.diff(drawn[:, 0]), drawn[1, 0] - drawn[0, 0], rtol=1e-4)  # one step an iteration
    # heights are an affine function of the logarithm, and the labels beside the axis say the same of the same heights
    slope, base = np.polyfit(np.log10(progress), drawn[:, 1], 1)
    assert slope < 0  # the view's second axis points down
    np.testing.assert_allclose(drawn[:, 1], base + slope * np.log10(progress), atol=1e-5)
    labels = entities["/design/progress/labels"]
    texts, places = labels["Points2D:labels"][0], np.array(labels["Points2D:positions"][0])
    decades = [(float(text), place[1]) for text, place in zip(texts, places, strict=True) if place[0] < 0]
    assert len(decades) >= 2
    values, heights = np.array(decades).T
    drop = heights - (base + slope * np.log10(values))
    np.testing.assert_allclose(drop, drop[0], atol=1e-5)
    assert {"iteration", "condition number"} <= set(texts)
    assert (drawn >= 0).all()
    assert (drawn <= [WIDTH, HEIGHT]).all()


def test_the_mark_stands_between_the_last_generation_and_ipopt(
    written: dict[str, Any], entities: dict[str, dict[str, list[Any]]]
) -> None:
    (strip,) = entities["/design/progress/condition_number"]["LineStrips2D:strips"][0]
    (mark,) = entities["/design/progress/ipopt/line"]["LineStrips2D:strips"][0]
    assert entities["/design/progress/ipopt/name"]["Points2D:labels"][0] == ["IPOPT begins"]
    before, after = strip[written["generations"] - 1][0], strip[written["generations"]][0]
    assert mark[0][0] == pytest.approx((before + after) / 2, abs=1e-5)


def test_the_planned_motion_and_its_limits_are_those_of_the_design(
    written: dict[str, Any], entities: dict[str, dict[str, list[Any]]]
) -> None:
    motion = plan_of(written["path"]).motion
    time, *states = motion.sample(RATE)
    for name, values in zip(("position", "velocity", "acceleration"), states, strict=True):
        for j in range(6):
            np.testing.assert_allclose(curve(entities, f"/design/{name}/{j + 1}"), values[:, j], atol=1e-9)
            np.testing.assert_allclose(entities[f"/design/{name}/{j + 1}"]["time"], time, atol=1e-8)
    text = entities["/design/limits"]["TextDocument:text"][0][0]
    assert f"{written['condition']:.4g}" in text
    assert all(f"{one['reached']:.4g} | {one['allowed']:.4g}" in text for one in written["margins"])


def test_it_opens_on_the_arm_the_chart_the_limits_and_the_curves(entities: dict[str, Any]) -> None:
    views = [e for e in entities["blueprint"].values() if "ViewBlueprint:space_origin" in e]
    origins = {view["ViewBlueprint:space_origin"][0][0] for view in views}
    shown = {"/design/robot", "/design/progress", "/design/limits"}
    assert shown | {f"/design/{part}" for part in ("position", "velocity", "acceleration")} <= origins
    for origin in origins:
        assert any(path.startswith(origin) for path in entities), f"{origin} opens empty"


def test_a_motion_alone_and_an_older_design_are_shown_without_a_chart(
    tmp_path: Path, written: dict[str, Any], ur5: pid.Robot
) -> None:
    old = {key: value for key, value in written.items() if key not in ("path", "progress", "generations")}
    motion = written["path"].with_name("motion.json")
    plan_of(written["path"]).motion.save(motion)
    (tmp_path / "old.json").write_text(json.dumps(old))
    for number, path in enumerate((motion, tmp_path / "old.json")):
        session = tmp_path / f"{number}.rrd"
        pid.view(to=session, plan=path, robot=ur5)
        reader = RrdReader(session)
        assert not any(path.startswith("/design/progress") for path in read(reader, reader.recordings()[0]))
        views = read(reader, reader.blueprints()[0]).values()
        assert not any("/design/progress" in view.get("ViewBlueprint:space_origin", [[None]])[0] for view in views)


@pytest.mark.parametrize("broken", [{"generations": 10**6}, {"generations": -1}, {"generations": "few"}])
def test_generations_that_cannot_be_are_one_line(tmp_path: Path, written: dict[str, Any], broken: dict) -> None:
    path = tmp_path / "broken.json"
    path.write_text(json.dumps({key: value for key, value in written.items() if key != "path"} | broken))
    with pytest.raises(pid.InputError, match=r"broken\.json") as told:
        plan_of(path)
    assert "\n" not in str(told.value)
