"""A diagnosis in files, small blocks, few surrogates at a time and two processes is that of one block in memory."""

from __future__ import annotations

from typing import Any

import pytest

import physident as pid
from physident.large_arrays import LARGE
from physident.processes import VARIABLE
from tests.exact_friction import exact_arm
from tests.plant import Sensors, hide, multisine, record

BLOCK = 256  # rows: a recording of the test has some hundreds after the filter


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[pid.Recording], list[pid.Recording]]:
    """Two recordings of a healthy arm, and two of the same arm with another friction on joint 2."""
    folder, later = tmp_path_factory.mktemp("blocks"), hide(exact_arm(), "load_dependent_friction", 2, 0.08)
    found = []
    for seed, arm in ((1, exact_arm()), (3, exact_arm()), (7, later), (9, later)):
        record(arm, multisine(seed), Sensors(), seed, step=2e-3).write_csv(folder / f"{seed}.csv")
        found.append(pid.load_recording(folder / f"{seed}.csv"))
    return found[:2], found[2:]


def test_a_diagnosis_in_blocks_is_that_of_one_block(
    recordings: tuple[list[pid.Recording], list[pid.Recording]], monkeypatch: pytest.MonkeyPatch
) -> None:
    clean, changed = recordings
    estimate = pid.identify("ur5", clean)
    whole = pid.diagnose_motion(estimate, changed).as_dict()
    assert any(
        finding["effect"] == "load_dependent_friction" and finding["joints"] == [2] for finding in whole["findings"]
    )
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
