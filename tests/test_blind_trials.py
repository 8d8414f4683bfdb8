"""A few of the blind trials of `studies/blind_trials`: hidden effects are named, healthy twins are left alone.

The study measures rates over hundreds of trials, on twelve arms and motions of 20 s. These trials prove that the whole chain still
works, from the plant to the verdict: each question and each strength once, and two effects at once, with seeds that
no reported figure uses. They share one arm, and their motions last 10 s. A threshold that is loosened, or a cause that is
lost, fails here in most trials and their twins; a rate that falls by a few per cent does not, and needs the study.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from studies.blind_trials import arms, run, trial

pytestmark = pytest.mark.slow

GROUP = 9
NAMED = {2: "missing strong", 4: "different middle"}  # trials by what they ask and how visible it is
WEAK, INVISIBLE, PAIR = 6, 9, run.PAIRS_FROM + 1
Row = dict[str, Any]


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for the recordings of this module: they are made anew, so that the plant is tested too."""
    return tmp_path_factory.mktemp("blind")


@pytest.fixture
def smaller(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One arm for all trials, and motions of half the length."""
    for module in (arms, trial):
        monkeypatch.setattr(module, "CACHE", cache)
    monkeypatch.setattr(trial, "ARMS", 1)
    monkeypatch.setattr(arms, "DURATION", 10.0)


def left_alone(row: Row) -> bool:
    """Whether nothing was found on the arm without the hidden effect, and no placebo anywhere."""
    return not row["twin"]["found"] and not row["twin"]["placebos"]


@pytest.mark.usefixtures("smaller")
@pytest.mark.parametrize("number", NAMED, ids=NAMED.get)
def test_a_hidden_effect_is_named_first_and_nothing_beside_it(number: int) -> None:
    row = run.judge((GROUP, number, False))
    assert f"{row['question']} {row['tier']}" == NAMED[number]
    score = row["score"]
    assert score["named"], run.line(row)
    assert score["size"] <= 3, run.line(row)
    assert not score["others"], run.line(row)
    assert score["gain"] > 80, run.line(row)  # % of what an oracle gains
    assert left_alone(row), run.line(row)


@pytest.mark.usefixtures("smaller")
def test_two_effects_at_once_are_both_named() -> None:
    row = run.judge((GROUP, PAIR, True))
    assert len(row["hidden"]) == 2
    assert row["score"]["named"], run.line(row)
    assert not row["score"]["others"], run.line(row)


@pytest.mark.usefixtures("smaller")
def test_an_effect_at_the_edge_of_sight_gets_no_wrong_name() -> None:
    row = run.judge((GROUP, WEAK, False))
    assert row["tier"] == "weak"
    assert row["score"]["told"] == "nothing" or row["score"]["first"], run.line(row)
    assert left_alone(row), run.line(row)


@pytest.mark.usefixtures("smaller")
def test_what_cannot_be_seen_is_said_so() -> None:
    row = run.judge((GROUP, INVISIBLE, False))
    assert row["tier"] == "invisible"
    assert row["score"]["unseen"]
    assert row["score"]["told"] == "nothing", run.line(row)
    assert left_alone(row), run.line(row)
