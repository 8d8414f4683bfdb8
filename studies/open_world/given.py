"""Is it the search that misses a cause? Every missed trial once more, the search begun with the hidden effect itself.

What is still not named then, no better search would name: the recordings leave it open, or it explains less than is left.
"""

from __future__ import annotations

import argparse
import json
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: one process a core

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.problem.problem import DiagnosisProblem
from physident.diagnosis.search import forward_search, turning_speeds
from physident.diagnosis.search.forward_search import SearchResult
from studies.open_world.bench import CACHE
from studies.open_world.drawing import drawn
from studies.open_world.judge import Clock, diagnosed
from studies.open_world.scoring import Score, score
from studies.open_world.trial import open_scene, parts
from tests.truth import HiddenEffect

FIELDS = {"stribeck_speed": "velocity", "slip": "distance", "time": "time_constant"}  # what the plants call otherwise


def given(world: str, group: int, number: int) -> Score | None:
    """The score of a single trial whose search has begun with the hidden effect; None for a contact, which has no place on the arm."""
    scene = open_scene(world, group, "single", number)
    trial = drawn(scene)
    (hidden,) = trial.hidden
    if hidden.effect == "contact":
        return None
    changed = scene.changed(trial.tag, *parts(scene, trial))
    with mock.patch.object(turning_speeds, "search_effects", _begun_with(hidden)):
        return score(scene, trial, changed, diagnosed(scene, changed, Clock()))


def _begun_with(hidden: HiddenEffect) -> Callable[..., SearchResult]:
    """The search of effects, begun with a hidden one of its true shape wherever that may be found."""

    def search(
        problem: DiagnosisProblem,
        progress: Callable[[str], None] = lambda _: None,
        begun: Sequence[AcceptedEffect] = (),
    ) -> SearchResult:
        if not begun:
            begun = (*problem.missing_default_effects, *_true_effect(problem, hidden))
        return forward_search.search_effects(problem, progress, begun)

    return search


def _true_effect(problem: DiagnosisProblem, hidden: HiddenEffect) -> tuple[AcceptedEffect, ...]:
    """The candidate that a hidden effect is, with its true shape."""
    true = {FIELDS.get(name, name): value for name, value in hidden.shape.items()}
    for candidate in problem.candidates:
        effect = candidate.options[0].effect
        if candidate.key == (hidden.effect, hidden.joints) and effect is not None:
            shapes = {shape.field: (float(true[shape.field]),) for shape in effect.shape_parameters}
            return (AcceptedEffect(candidate, replace(effect, **shapes)),)
    return ()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--world", choices=("first", "again", "second"), default="first")
    parser.add_argument("--sets", nargs="+", type=int, required=True, help="sets whose trials were run")
    asked = parser.parse_args()
    missed = named = 0
    for group in asked.sets:
        rows = map(json.loads, (CACHE / asked.world / f"set{group}.jsonl").read_text(encoding="utf-8").splitlines())
        for number, row in {row["number"]: row for row in rows if row["kind"] == "single" and "score" in row}.items():
            if row["tier"] == "weak" or row["score"]["first"]:
                continue
            found = given(asked.world, group, number)
            missed, named = missed + (found is not None), named + bool(found and found.first)
            words = "a contact, not tried" if found is None else "first" if found.first else f"not first: {found.told}"
            print(f"set {group}, trial {number} ({row['strata']['question']}, {row['tier']}): {words}", flush=True)
    print(f"{named} of {missed} missed causes come first where the search begins with them")


if __name__ == "__main__":
    main()
