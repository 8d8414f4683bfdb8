"""How sure a change must be depends on how many recordings say by how much healthy ones differ."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from physident.diagnosis.grading import control
from physident.diagnosis.grading.scatter import Scatter

SURE = 1e-9  # how often noise alone makes such a difference


@pytest.mark.parametrize(
    ("usual", "count", "tested", "changed"),
    [(0.02, 3, 1, 1), (0.02, 4, 1, 0), (0.004, 4, 1, 1), (0.004, 4, 2, 2), (0.0075, 4, 2, 1), (0.06, 2, 1, 0)],
)
def test_what_healthy_recordings_differ_by_is_held_to_the_level_of_noise_once_enough_say_it(
    usual: float, count: int, tested: int, changed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    joint = SimpleNamespace(
        differences=lambda left: [control.Difference(size=1.0, noise=SURE, usual=usual)] * len(left),
        scatter=lambda _: Scatter(variance=1.0, count=count),
    )
    monkeypatch.setattr(control, "_joint_fit", lambda *_: joint)
    problem = SimpleNamespace(model=SimpleNamespace(theta=np.zeros(3)))
    places = [np.array([3 + k]) for k in range(tested)]
    hypothesis: Any = SimpleNamespace(problem=problem, extension=SimpleNamespace(places=places))
    assert sum(one.size != 0 for one in control.changes_of(hypothesis, (), range(tested))) == changed


@pytest.mark.parametrize(("size", "changed"), [(1.0, True), (0.6, True), (0.4, False), (-0.2, False)])
def test_what_was_mostly_there_before_has_not_appeared(
    size: float, changed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However certain it is that an arm's bristles give a little less than before."""
    joint = SimpleNamespace(
        differences=lambda left: [control.Difference(size=size, noise=SURE, usual=SURE)] * len(left),
        scatter=lambda _: Scatter(variance=0.0, count=4),
    )
    monkeypatch.setattr(control, "_joint_fit", lambda *_: joint)
    hypothesis: Any = SimpleNamespace(
        problem=SimpleNamespace(model=SimpleNamespace(theta=np.zeros(3))),
        extension=SimpleNamespace(places=[np.array([3])]),
    )
    assert (control.changes_of(hypothesis, (), [0])[0].size != 0) == changed


def test_of_two_that_are_not_mostly_new_the_less_certain_goes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two effects share one change; alone, either has it all, and only the more certain one should be told."""

    def differences(left: list[int]) -> list[control.Difference]:
        size = 0.45 if len(left) == 2 else 0.9
        return [
            control.Difference(size=size, noise=(SURE, 0.9)[k] if len(left) == 2 else SURE, usual=SURE) for k in left
        ]

    joint = SimpleNamespace(differences=differences, scatter=lambda _: Scatter(variance=0.0, count=4))
    monkeypatch.setattr(control, "_joint_fit", lambda *_: joint)
    hypothesis: Any = SimpleNamespace(
        problem=SimpleNamespace(model=SimpleNamespace(theta=np.zeros(3))),
        extension=SimpleNamespace(places=[np.array([3]), np.array([4])]),
    )
    assert [one.size != 0 for one in control.changes_of(hypothesis, (), [0, 1])] == [True, False]


@pytest.mark.parametrize(("alone", "places", "changed"), [
    (0.3, 3, (False, False)), (SURE, 3, (True, True)), (0.3, 1, (True, True)),
])  # fmt: skip
def test_an_effect_that_differs_only_beside_another_has_not_appeared(
    alone: float, places: int, changed: tuple[bool, bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bristles and a curve that share one torque are certain to differ, the one by as much as the other takes back. Of values that the model has
    both may have changed."""

    def differences(left: list[int]) -> list[control.Difference]:
        together = control.Difference(size=0.6, noise=SURE, usual=SURE)
        by_itself = control.Difference(size=0.6, noise=alone, usual=SURE)
        return [together if len(left) == 2 else by_itself for _ in left]

    joint = SimpleNamespace(differences=differences, scatter=lambda _: Scatter(variance=0.0, count=4))
    monkeypatch.setattr(control, "_joint_fit", lambda *_: joint)
    hypothesis: Any = SimpleNamespace(
        problem=SimpleNamespace(model=SimpleNamespace(theta=np.zeros(3))),
        extension=SimpleNamespace(places=[np.array([2]), np.array([places])]),
    )
    assert tuple(one.size != 0 for one in control.changes_of(hypothesis, (), [0, 1])) == changed


@pytest.mark.parametrize(("size", "noise", "told"), [(0.95, 0.005, True), (0.4, 0.005, False), (0.95, 0.3, False)])
def test_what_is_mostly_new_is_told_apart_though_it_is_no_proven_change(
    size: float, noise: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A channel that has become late is not missing since before, where few recordings differ by too much to prove it."""
    joint = SimpleNamespace(
        differences=lambda left: [control.Difference(size=size, noise=noise, usual=0.12)] * len(left),
        scatter=lambda _: Scatter(variance=1.0, count=6),
    )
    monkeypatch.setattr(control, "_joint_fit", lambda *_: joint)
    hypothesis: Any = SimpleNamespace(
        problem=SimpleNamespace(model=SimpleNamespace(theta=np.zeros(3))),
        extension=SimpleNamespace(places=[np.array([3])]),
    )
    assert control.changes_of(hypothesis, (), [0]) == (control.Change(size=0.0, mostly_new=told),)


def test_what_differs_only_beside_a_change_of_its_own_has_appeared(monkeypatch: pytest.MonkeyPatch) -> None:
    """While a payload is held alike, what it leaves hides that friction has grown: only two of which neither differs by itself share one torque."""

    def differences(left: list[int]) -> list[control.Difference]:
        return [control.Difference(size=0.9, noise=SURE if 0 in left else 0.4, usual=SURE) for _ in left]

    joint = SimpleNamespace(differences=differences, scatter=lambda _: Scatter(variance=0.0, count=4))
    monkeypatch.setattr(control, "_joint_fit", lambda *_: joint)
    hypothesis: Any = SimpleNamespace(
        problem=SimpleNamespace(model=SimpleNamespace(theta=np.zeros(3))),
        extension=SimpleNamespace(places=[np.array([3]), np.array([4])]),
    )
    assert [one.size for one in control.changes_of(hypothesis, (), [0, 1])] == [0.9, 0.9]
