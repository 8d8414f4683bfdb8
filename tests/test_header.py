"""Names of columns: those that a UR controller writes, numbers by name, and settings beside the columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physident as pid
from physident.recordings.columns.layout import ColumnLayout
from physident.recordings.columns.reading import Reading, reading_text
from tests.bad_input.good import table

RTDE = (
    "timestamp",
    *(
        f"{kind}_{j}"
        for kind in ("target_q", "actual_q", "actual_qd", "actual_current", "target_moment")
        for j in range(6)
    ),
    *(f"joint_temperatures_{j}" for j in range(6)),
    "runtime_state",
)


@pytest.mark.parametrize("separator", [" ", ",", "\t", ";"])
@pytest.mark.parametrize("comment", ["", "# "])
def test_a_log_of_rtde_is_read_by_its_names(tmp_path: Path, separator: str, comment: str) -> None:
    values = table()
    q, dq, current = values[:, 1:7], values[:, 7:13], values[:, 13:]
    warm = 30 + 0.01 * np.arange(len(q))[:, None] + np.arange(6)
    rows = np.column_stack([1e6 + values[:, 0], q + 0.01, q, dq, current, 10 * current, warm, np.full(len(q), 2)])
    lines = [comment + separator.join(RTDE), *(separator.join(map(repr, row)) for row in rows.tolist())]
    (tmp_path / "log.txt").write_text("\n".join(lines))
    log = pid.load_recording(tmp_path / "log.txt", drive_gains=[10.0] * 6)
    assert log.effort_kind == "current"
    assert log.dq is not None
    assert log.temperature is not None
    for found, expected in ((log.q, q), (log.dq, dq), (log.effort, current), (log.temperature, warm)):
        np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(log.time, 1e6 + values[:, 0])
    assert set(log.ignored) == {name for name in RTDE if name.startswith("target") or name == "runtime_state"}


def test_the_canonical_header_comes_first() -> None:
    names = ["timestamp", "time", "q_1", "actual_q_0", "tau_1"]
    assert ColumnLayout.from_header(names, "test") == ColumnLayout(time=1, q=(2,), effort=(4,), effort_kind="torque")
    with pytest.raises(pid.InputError, match="q is given for joints 1, 3"):
        ColumnLayout.from_header(["timestamp", "actual_q_0", "actual_q_2", "actual_current_0"], "test")


def test_effort_of_an_unknown_kind() -> None:
    layout = ColumnLayout.from_header(["time", "q_1", "effort_1"], "test")
    assert (layout.effort_kind, layout.effort_stated) == ("torque", False)


@given(
    st.none() | st.just("q=0:6,tau=6:12"),
    st.none() | st.just("/joint_states"),
    st.none() | st.floats(1e-3, 1e5),
    st.none() | st.just("time=0,q=1:7,current=7:13,topic=/old,rate=500"),
)
def test_options_replace_what_a_model_remembers(
    columns: str | None, topic: str | None, rate: float | None, remembered: str | None
) -> None:
    text = reading_text(columns, topic, rate, remembered)
    found = Reading() if text is None else Reading.parse(text)
    old = Reading() if remembered is None else Reading.parse(remembered)
    assert found.columns == (columns or old.columns)
    assert found.topic == (topic or old.topic)
    assert found.rate == (old.rate if rate is None else pytest.approx(rate, rel=1e-11))


def test_columns_by_name() -> None:
    names = ["t", *(f"x_{k}" for k in range(4)), "f_1", "f_2", "x_10"]
    layout = ColumnLayout.parse("time=t,q=x[2:4],tau=f", names)
    assert layout == ColumnLayout(time=0, q=(3, 4), effort=(5, 6), effort_kind="torque")
    assert ColumnLayout.parse("time=t,q=x[4],tau=f[0]", names).q == (7,)
    kinova = ["Time", "Position1", "Position2", "PositionCmptd1", "PositionCmptd2", "Cur2", "Cur1"]
    layout = ColumnLayout.parse("q=Position,current=Cur", kinova, clock=False)
    assert layout == ColumnLayout(time=None, q=(1, 2), effort=(6, 5), effort_kind="current")


def test_numbers_that_take_a_named_column_for_another_channel_are_refused() -> None:
    names = ["time", "q_1", "q_2", "tau_1", "tau_2"]
    with pytest.raises(pid.InputError, match=r"calls column 3 'tau_1', but .* take it for current"):
        ColumnLayout.parse("time=0,q=1:3,current=3:5", names)
    assert ColumnLayout.parse("time=0,q=1:3,tau=3:5", names).effort_kind == "torque"
    by_name = ColumnLayout.parse("time=time,q=q,current=tau", names)  # a name is meant as it is written
    assert by_name.effort_kind == "current"
    assert ColumnLayout.parse("time=0,q=1:3,current=3:5", [*names[:3], "effort_1", "effort_2"]).effort == (3, 4)
