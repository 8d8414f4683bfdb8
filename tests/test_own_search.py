"""The search of a model's own recordings is remembered, and begun anew where anything that it depends on is another."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.grading import completed
from physident.effects.effect import Effect


@pytest.fixture
def run() -> pid.Recording:
    time = np.arange(400) / 100
    wave = np.sin(time)[:, None] * np.ones((1, 2))
    return pid.Recording.from_arrays(time=time, q=wave, effort=wave, drive_gains=(10.0, 10.0))


@pytest.fixture
def searched(monkeypatch: pytest.MonkeyPatch) -> Any:
    """How often the search ran after it was asked of some recordings by a seed."""
    runs: list[int] = []

    def search(problem: object) -> SimpleNamespace:
        runs.append(1)
        return SimpleNamespace(last=SimpleNamespace(hypothesis=SimpleNamespace(problem=SimpleNamespace(forget=list))))

    monkeypatch.setattr(completed, "search_and_learn", search)
    monkeypatch.setattr(completed, "state_problem", lambda *_: None)
    monkeypatch.setattr(completed, "_last", [])
    estimate: Any = SimpleNamespace(filter=None)

    def ask(recording: pid.Recording, seed: int = 0, of: Any = estimate) -> int:
        completed._searched(of, [recording], [], seed, lambda _: None)
        return len(runs)

    return ask


def test_the_same_is_searched_once(searched: Any, run: pid.Recording) -> None:
    assert searched(run) == 1
    assert searched(replace(run)) == 1


def test_other_gains_temperatures_seeds_models_and_effects_are_searched_anew(
    searched: Any, run: pid.Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert searched(run) == 1
    assert searched(replace(run, drive_gains=(20.0, 20.0))) == 2
    assert searched(replace(run, temperature=np.full(run.q.shape, 30.0))) == 3
    assert searched(replace(run, temperature=np.full(run.q.shape, 40.0))) == 4
    assert searched(run, seed=1) == 5
    assert searched(run, seed=1, of=SimpleNamespace(filter=None)) == 6

    class Another(Effect):
        """An effect that a user defined anew under the same name."""

    monkeypatch.setitem(completed.CATALOGUE, "viscous_friction", Another)
    assert searched(run, seed=1) == 7
