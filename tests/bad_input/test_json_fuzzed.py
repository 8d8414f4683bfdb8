"""Files of JSON with any entry replaced by a hostile value load, or say why not in one line, and quickly."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import physident as pid
from physident.diagnosis.result.saved import read_diagnosis
from physident.export.parameters import parameters_of
from physident.export.python import python_of
from physident.graphics.plan import plan_of
from physident.report.page import report_html
from physident.simulation.sensors import load_sensors

FILES = Path(__file__).parents[1] / "files"
LIMIT = 5.0  # s for a file of some kB
TEXTS = st.sampled_from(
    ["", "x", "\0", "\ud800", "\udc80", "../../x", "a\nb", "é" * 300, "<script>", "1e3", "nan", "%s{0}"]
)
NUMBERS = st.sampled_from(
    [0, -1, 1e308, -1e308, 1e-320, 5e-324, 1e-150, 1e149, 10**400, 2**63, 0.5, float("nan"), float("inf"), 1e16]
)
PLAIN = st.one_of(st.none(), st.booleans(), NUMBERS, TEXTS, st.integers(-9, 99), st.floats(-1e3, 1e3))
VALUES = st.one_of(PLAIN, st.lists(PLAIN, max_size=3), st.dictionaries(st.sampled_from(["a", "rate", "name"]), PLAIN))


def use_model(path: Path) -> None:
    """What verbs do with a model that has loaded: print, export and predict."""
    estimate = pid.load_estimate(path)
    repr(estimate)
    repr(estimate.model)
    json.dumps(parameters_of(estimate))
    json.dumps(estimate.as_dict(), allow_nan=False)
    compile(python_of(estimate.model), "exported", "exec")


def use_diagnosis(path: Path) -> None:
    record = read_diagnosis(path)
    report_html(path)
    json.dumps(record.as_dict(), allow_nan=False)


def use_trajectory(path: Path) -> None:
    pid.load_trajectory(path).sample(20.0)
    plan_of(path)


def use_sensors(path: Path) -> None:
    load_sensors(path)


SENSORS = {"schema": "physident.sensors/1", "torque_noise": [0.1, 0.2], "velocity_noise": 1e-3, "rate": 125.0}
KINDS: dict[str, Callable[[Path], None]] = {
    "model.json": use_model, "diagnosis.json": use_diagnosis, "trajectory.json": use_trajectory, "sensors.json": use_sensors,
}  # fmt: skip


def content(name: str) -> Any:
    return SENSORS if name == "sensors.json" else json.loads((FILES / name).read_text())


def places(value: Any, path: tuple = ()) -> list[tuple]:
    """The path of every entry, of long lists the first and the last."""
    if isinstance(value, dict):
        inner = list(value.items())
    elif isinstance(value, list):
        inner = [(i, value[i]) for i in sorted({0, len(value) - 1}) if value]
    else:
        inner = []
    found = [(*path, key) for key, _ in inner]
    return found + [deeper for key, one in inner for deeper in places(one, (*path, key))]


def replace_entry(data: Any, place: tuple, value: Any) -> None:
    """Replace an entry in place, where an earlier change has left it there."""
    for key in place[:-1]:
        try:
            data = data[key]
        except (TypeError, LookupError):
            return
    if isinstance(data, dict) or (isinstance(data, list) and isinstance(place[-1], int) and place[-1] < len(data)):
        data[place[-1]] = value


@pytest.mark.filterwarnings("ignore::physident.PhysidentWarning", "error::RuntimeWarning:physident")
@pytest.mark.parametrize("name", KINDS)
def test_any_entry_replaced_loads_or_is_refused_in_one_line(name: str, tmp_path: Path) -> None:
    original = content(name)
    everywhere, path = places(original), tmp_path / name

    @settings(
        max_examples=300, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
    )
    @given(st.lists(st.tuples(st.sampled_from(everywhere), VALUES), min_size=1, max_size=2))
    def one(changes: list[tuple[tuple, Any]]) -> None:
        data = json.loads(json.dumps(original))
        for place, value in changes:
            replace_entry(data, place, value)
        path.write_text(json.dumps(data))
        start, said = time.process_time(), ""
        try:
            KINDS[name](path)
        except pid.PhysidentError as error:
            said = str(error)
        assert len(said.splitlines()) <= 1
        assert time.process_time() - start < LIMIT

    one()
