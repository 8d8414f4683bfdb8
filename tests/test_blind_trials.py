"""A few blind trials of `studies/blind_trials`: hidden effects are named, healthy twins are left alone."""

from __future__ import annotations

import pytest

from studies.blind_trials import arms, trial
from studies.blind_trials.run import PAIRS_FROM, judge

GROUP = 9  # seeds that no reported figure uses


@pytest.fixture(scope="module", autouse=True)
def recordings(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Recordings are made anew, so that the plant is tested too."""
    folder = tmp_path_factory.mktemp("blind")
    arms.CACHE = trial.CACHE = folder


@pytest.mark.parametrize("number", [1, 2, 4, 5, 7, 8])
def test_an_effect_that_an_oracle_sees_is_named_first_and_alone_and_its_twin_is_left_alone(number: int) -> None:
    row = judge((GROUP, number, False))
    assert row["tier"] in ("middle", "strong")
    found = row["score"]
    assert found["first"], found["told"]
    assert found["size"] <= 3
    assert found["others"] == 0, found["told"]
    assert found["gain"] is None or found["gain"] > 80
    assert row["twin"]["found"] == []
    assert row["twin"]["placebos"] == 0


@pytest.mark.parametrize("number", [0, 3])
def test_an_effect_at_the_edge_of_sight_gets_no_wrong_name(number: int) -> None:
    row = judge((GROUP, number, False))
    assert row["tier"] == "weak"
    assert row["score"]["told"] == "nothing" or row["score"]["first"], row["score"]["told"]
    assert row["twin"]["found"] == []


def test_what_cannot_be_seen_is_said_so() -> None:
    row = judge((GROUP, 9, False))
    assert row["tier"] == "invisible"
    assert row["score"]["unseen"]
    assert row["score"]["told"] == "nothing"


def test_two_effects_at_once_are_both_named() -> None:
    row = judge((GROUP, PAIRS_FROM + 1, True))
    assert row["score"]["named"], row["score"]["told"]
    assert row["score"]["others"] == 0, row["score"]["told"]
