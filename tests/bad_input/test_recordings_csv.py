"""Tables of text that are no recording."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from physident.cli import run
from tests.bad_input.good import CURRENT, GOOD, HEADER, Content, as_csv, table, write
from tests.bad_input.one_line_error import fails, refused_recording


def broken(change: Callable[[np.ndarray], Any], header: str = HEADER) -> str:
    """The good table after a change in place, or the one that the change returns."""
    values = table()
    changed = change(values)
    return as_csv(values if changed is None else changed, header)


def put(rows: slice | list[int], columns: Any, value: float) -> Callable[[np.ndarray], None]:
    def change(values: np.ndarray) -> None:
        values[rows, columns] = value

    return change


def scaled(columns: slice, factor: float) -> Callable[[np.ndarray], None]:
    def change(values: np.ndarray) -> None:
        values[:, columns] *= factor

    return change


CSV: dict[str, tuple[Content, str]] = {
    # name of the case: content, what the line must say
    "empty": ("", "empty"),
    "header only": (HEADER + "\n", "no rows"),
    "one line without newline": (HEADER, "no rows"),
    "blank lines": ("\n" * 50, "comma"),
    "binary": (bytes(range(256)) * 40, "not a text file"),
    "latin-1 header": (("zeit_µ," + GOOD).encode("latin-1"), "UTF-8"),
    "utf-16": (GOOD.encode("utf-16"), "UTF-16|not a text file"),
    "one column": ("time\n" + "1\n" * 300, "one column"),
    "comments only": ("# a log\n# of an arm\n", "one column|rows of numbers"),
    "comments without end": ("# a log\n" * 3000, "rows of numbers"),
    "commas of thousands": (re.sub(r"(?m)^([0-9])", r"1,00\1", GOOD.replace(",", ";")), "400 of 400 rows are bad"),
    "decimal commas between commas": (as_csv(table()).replace(".", ","), "fields, expected|bad"),
    "a space in every row": (re.sub(r"(?m)^([0-9])", r"1 \1", GOOD.replace(",", " ")), "20 fields, expected 19"),
    "prose": ("Dear arm,\nplease move, then rest,\nyours\n", "time"),
    "html": ("<html><head>\n<title>404, not found</title>\n</html>\n", "comma"),
    "no time column": (GOOD.replace("time", "clock", 1), "no time column"),
    "no header": (as_csv(table(), ""), "no header.*--columns"),
    "no positions": (GOOD.replace(",q_", ",angle_"), "no joint positions"),
    "no effort": (GOOD.replace("tau_", "force_"), "neither tau nor current"),
    "both efforts": (GOOD.replace("dq_", "current_"), "both tau and current"),
    "joint numbers missing": (GOOD.replace("q_4", "q_7", 1).replace("dq_7", "dq_4"), "joints 1, 2, 3, 5, 6, 7"),
    "joints from zero": (GOOD.replace("q_6", "q_0"), "joints 0, 1, 2"),
    "fewer efforts than positions": (GOOD.replace("tau_6", "extra"), "5 columns of tau and 6 of q"),
    "duplicate column": (GOOD.replace("q_2", "q_1", 1), "twice"),
    "duplicate time": (GOOD.replace("dq_6", "time"), "twice"),
    "wrong column count throughout": (HEADER + "\n" + "1,2,3\n" * 300, "300 of 300 rows.*3 fields"),
    "truncated lines": (re.sub(r"(?m)^([^\n]*?7[^\n]*),[^,\n]*$", r"\1", GOOD), "18 fields, expected 19"),
    "text cells": (HEADER + "\n" + ("x," * 18 + "x\n") * 300, "bad"),
    "all NaN": (broken(put(slice(None), slice(1, None), np.nan)), "bad"),
    "all infinite": (broken(put(slice(None), 3, np.inf)), "bad"),
    "clock NaN": (broken(put(slice(None), 0, np.nan)), "bad"),
    "over half the rows bad": (broken(put(slice(0, 205), 9, 1e290)), "205 of 400 rows"),
    "over half missing fields": (GOOD + "1,2\n" * 500, "500 of 900"),
    "under two seconds": (broken(lambda v: v[:150]), "1.49 s"),
    "one row": (broken(lambda v: v[:1]), "0 s of good rows"),
    "degrees": (broken(scaled(slice(1, 13), 57.3)), "4 pi.*degrees"),
    "milliseconds": (broken(scaled(slice(0, 1), 1000.0)), "milliseconds"),
    "microseconds": (broken(scaled(slice(0, 1), 1e6)), "microseconds"),
    "nanosecond stamps": (broken(scaled(slice(0, 1), 1e9)), "nanoseconds"),
    "clock stands": (broken(put(slice(None), 0, 1.0)), "clock"),
    "clock backwards": (broken(lambda v: v[::-1]), "clock"),
    "clock restarts": (broken(lambda v: np.concatenate([v[:100]] * 4)), "clock"),
    "clock in absurd steps": (broken(lambda v: v.__setitem__((slice(None), 0), 1e300 * v[:, 0])), "seconds"),
    "100,000 columns": (",".join(f"c{i}" for i in range(100_000)) + "\n" + "1," * 99_999 + "1\n", "100000 columns"),
    "a directory": (lambda p: p.mkdir(), "folder|not a file"),
    "a pipe": (os.mkfifo, "not a file|neither"),
    "unreadable": (lambda p: p.symlink_to("/proc/self/mem"), "cannot be read"),
    "dangling link": (lambda p: p.symlink_to("nowhere.csv"), "not found"),
}


@pytest.mark.parametrize("case", CSV)
def test_csv(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    content, says = CSV[case]
    write(folder / "r.csv", content)
    refused_recording(capfd, folder, "r.csv", says)


def test_currents_need_gains(folder: Path, capfd: pytest.CaptureFixture) -> None:
    (folder / "currents.csv").write_text(as_csv(table(), CURRENT))
    fails(capfd, folder, ["identify", "currents.csv", "--robot", "ur5", "--out", "out.json"], "no drive gains")
    assert run(["inspect", "currents.csv"]) == 0


def test_joint_counts_must_agree(folder: Path, capfd: pytest.CaptureFixture) -> None:
    three = as_csv(table()[:, [0, 1, 2, 3, 13, 14, 15]], "time,q_1,q_2,q_3,tau_1,tau_2,tau_3")
    (folder / "three.csv").write_text(three)
    says = "3 joints, but robot ur5 has 6"
    fails(capfd, folder, ["identify", "three.csv", "--robot", "ur5", "--out", "out.json"], says)
    fails(capfd, folder, ["validate", "three.csv", "--model", "model.json"], says)


def test_static_poses_load_but_cannot_be_identified(folder: Path, capfd: pytest.CaptureFixture) -> None:
    (folder / "still.csv").write_text(broken(lambda v: v.__setitem__((slice(None), slice(1, 13)), 0.0)))
    assert run(["inspect", "still.csv"]) == 0
    assert "no joint moves" in capfd.readouterr().out
    fails(capfd, folder, ["identify", "still.csv", "--robot", "ur5", "--out", "out.json"], "no joint moves")
