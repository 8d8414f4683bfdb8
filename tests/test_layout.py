"""Which column is what: the canonical header and the declared layout say the same."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physident import InputError
from physident.recordings.columns.layout import ColumnLayout


@given(st.integers(1, 9), st.booleans(), st.booleans(), st.sampled_from(["tau", "current"]), st.randoms())
def test_a_header_in_any_order_finds_its_columns(n: int, dq: bool, warm: bool, effort: str, random) -> None:
    kinds = ["q", effort, *(["dq"] if dq else []), *(["temperature"] if warm else [])]
    names = ["time", "extra", *(f"{kind}_{j}" for kind in kinds for j in range(1, n + 1))]
    random.shuffle(names)
    layout = ColumnLayout.from_header(names, "header")
    values = np.arange(2 * len(names)).reshape(2, -1).astype(float)
    channels = layout.split(values)
    np.testing.assert_array_equal(channels.time, values[:, names.index("time")])
    for channel, kind in (
        (channels.q, "q"),
        (channels.effort, effort),
        (channels.dq, "dq"),
        (channels.temperature, "temperature"),
    ):
        if kind in kinds:
            assert channel is not None
            for j in range(n):
                np.testing.assert_array_equal(channel[:, j], values[:, names.index(f"{kind}_{j + 1}")])
        else:
            assert channel is None
    assert layout.unused(names) == ("extra",)
    assert layout.effort_kind == ("torque" if effort == "tau" else "current")


def test_a_declared_layout_is_the_header_it_describes() -> None:
    names = ["time", *(f"{kind}_{j}" for kind in ("q", "dq", "current") for j in range(1, 7))]
    assert ColumnLayout.parse(" time=0, q=1:7 ,dq=7:13,current=13:19") == ColumnLayout.from_header(names, "header")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("time=0,q=7:1,tau=8:14", "empty range"),
        ("time=0,q=1:7,tau=6:12", "column 6 is in two channels"),
        ("time=3,q=1:7,tau=7:13", "column 3 is in two channels"),
        ("time=0,q=1:7,tau=7:12", "5 columns of tau and 6 of q"),
        ("time=0:2,q=2:4,tau=4:6", "no time column"),
        ("time=0,q=1:3,tau=3:5,current=5:7", "both tau and current"),
    ],
)
def test_layouts_that_cannot_be(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        ColumnLayout.parse(text)


def test_a_layout_wider_than_the_table() -> None:
    ColumnLayout.parse("time=0,q=1,tau=2").check_width(3, "table")
    with pytest.raises(InputError, match="3 columns, but its layout names column 3"):
        ColumnLayout.parse("time=0,q=1,tau=3").check_width(3, "table")
