"""A diagnosis in files, small blocks, few surrogates at a time and two processes is that of one block in memory."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import physident as pid
from physident.large_arrays import LARGE
from physident.processes import VARIABLE
from tests.serial_arms import ARMS, urdf
from tests.test_friction_level_of_bristles import LEVEL, MORE, ORDINARY, recorded

pytestmark = pytest.mark.slow

DURATION = 16.0  # s: so that every signal still takes more than one block
BLOCK = 256  # rows: a recording of the test has some hundreds after the filter


def test_a_diagnosis_in_blocks_is_that_of_one_block(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "two.urdf").write_text(urdf(ARMS["two"]))
    estimate = pid.identify(
        pid.load_robot(tmp_path / "two.urdf"), [recorded(seed, LEVEL, DURATION) for seed in (1, 2)], ORDINARY
    )
    changed = [recorded(seed, LEVEL + MORE, DURATION) for seed in (3, 4)]
    whole = pid.diagnose_motion(estimate, changed).as_dict()
    assert any(finding["grade"] == "cause" and finding["joints"] == [1] for finding in whole["findings"])
    monkeypatch.setenv(VARIABLE, "2")
    for place in (
        "large_arrays.BLOCK",
        "large_arrays.STEP",
        "dynamics.model.BLOCK",
        "dynamics.column_structure.BLOCK",
        "effects.hysteresis.BLOCK",
        "diagnosis.statistics.row_products.BLOCK",
        "diagnosis.statistics.row_products.STEP",
        "diagnosis.statistics.stored_products.STEP",
    ):
        monkeypatch.setattr(f"physident.{place}", BLOCK)
    monkeypatch.setattr("physident.diagnosis.search.candidate_scores.AT_ONCE", 1 << 20)
    monkeypatch.setattr("physident.diagnosis.search.contact_scan.WINDOWS", 1 << 12)
    token = LARGE.set(1000)
    try:
        pieces = pid.diagnose_motion(estimate, changed).as_dict()
    finally:
        LARGE.reset(token)
    assert_alike(pieces, whole)


def assert_alike(found: Any, expected: Any) -> None:
    """The same texts, and numbers that differ by rounding."""
    if isinstance(expected, dict):
        assert found.keys() == expected.keys()
        for key in expected:
            assert_alike(found[key], expected[key])
    elif isinstance(expected, list | tuple):
        assert len(found) == len(expected)
        for one, other in zip(found, expected, strict=True):
            assert_alike(one, other)
    elif isinstance(expected, float):
        # directions that the data hardly decide carry the rounding of the others
        assert found == pytest.approx(expected, rel=1e-5, abs=1e-7)
    else:
        assert found == expected
