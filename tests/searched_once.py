"""One search for tests of what is done with what was found: it takes most of a diagnosis' time."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from physident.diagnosis.learned.search_and_learn import search_and_learn
from physident.diagnosis.problem.problem import DiagnosisProblem
from physident.diagnosis.search.forward_search import SearchResult


def searched_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the first search of each question answer all later ones, which must be of the same model and recordings."""
    found: dict[str, SearchResult] = {}

    def search(problem: DiagnosisProblem, progress: Callable[[str], None] = lambda _: None) -> SearchResult:
        if problem.question not in found:
            found[problem.question] = search_and_learn(problem, progress)
        return found[problem.question]

    for module in ("searched", "grading.completed"):
        monkeypatch.setattr(f"physident.diagnosis.{module}.search_and_learn", search)
