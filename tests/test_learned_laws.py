"""Which law keeps its name before a learned curve: one that takes as much as values are asked to be known, or all but what the model errs by
anyway, and that the arm can have."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from physident.diagnosis.learned import learn, nearest_law

# squared shares: a law whose torque is 10 % of the curve's RMS away takes 99 % of its power, one that is 20 % away 96 %
NEAR, FAR, OFF = 1 - 0.10**2, 1 - 0.20**2, 1 - 0.40**2
POWER, ROWS = 4.0, 500  # of a curve in each row [(N m)^2], and how many rows


def beside(usual_error: float | None, monkeypatch: pytest.MonkeyPatch, shares: dict[str, float]) -> Any:
    """A hypothesis in which laws of joint 1 take some shares of a curve's power, and whose model usually errs by so much there [N m]."""
    gain = POWER * ROWS * np.array([1.0, *shares.values()])
    monkeypatch.setattr(nearest_law, "laws_of_joint", lambda _rest, _joints: list(shares))
    monkeypatch.setattr(nearest_law, "left_out_gains", lambda *_, **__: SimpleNamespace(gain=gain[:, None, None, None]))
    monkeypatch.setattr(nearest_law, "replace", lambda data, **_: data)
    power = 0.0 if usual_error is None else ROWS * usual_error**2
    return SimpleNamespace(data=None, baseline=None, fit=None, products=None, usual_power=lambda _joint: power)


@pytest.mark.parametrize(
    ("shares", "impossible", "named"),
    [
        ({"ripple": NEAR, "spring": 0.4}, (), "ripple"),
        ({"ripple": FAR, "spring": 0.4}, (), None),
        ({"ripple": NEAR, "spring": 0.995}, (), "spring"),
        ({"ripple": NEAR, "spring": 0.995}, ("spring",), "ripple"),
        ({"ripple": FAR, "spring": 0.995}, ("spring",), None),
        ({}, (), None),
    ],
)
def test_the_nearest_possible_law(
    shares: dict[str, float], impossible: tuple[str, ...], named: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    rest = beside(None, monkeypatch, shares)
    monkeypatch.setattr(learn, "is_admissible", lambda _rest, law: law not in impossible)
    monkeypatch.setattr(learn, "refine_shape", lambda _rest, law: law)
    curve: Any = SimpleNamespace(joints=(1,))
    found = learn._law_of_its_shape(rest, curve)
    assert (None if found is None else found.effect) == named


@pytest.mark.parametrize(
    ("share", "usual_error", "enough"),
    [
        (FAR, None, False),
        (FAR, 0.41, True),  # it leaves 0.4 N m of the curve's 2 N m
        (FAR, 0.39, False),
        (OFF, 1.0, False),  # 0.8 N m are less than the model errs by, and yet another shape
        (NEAR, 0.0, True),
    ],
)
def test_a_shape_that_the_model_errs_by_anyway_is_no_curve(
    share: float, usual_error: float | None, enough: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    curve: Any = SimpleNamespace(joints=(1,))
    (near,) = nearest_law.laws_by_share(beside(usual_error, monkeypatch, {"spring": share}), curve)
    assert near.share == pytest.approx(share)
    assert near.is_enough is enough


@pytest.mark.parametrize(
    ("law_of", "usual_error", "learned"),
    [("position", 3.0, False), ("position", 1.0, True), ("velocity", 3.0, True), (None, 3.0, True)],
)
def test_beside_a_law_of_the_same_quantity_a_curve_is_more_than_what_the_model_errs_by(
    law_of: str | None, usual_error: float, learned: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The curve takes 2 N m of its joint, and every other condition is met."""
    curve = SimpleNamespace(joints=(1,), placebo=False)
    gains = SimpleNamespace(
        gain=np.full((1, 1, 1, 1), POWER * ROWS),
        evidence=np.array([[100.0]]),
        evidence_without_best_fold=np.array([[50.0]]),
        visible=np.ones(1),
    )
    monkeypatch.setattr(learn, "replace", lambda data, **_: data)
    monkeypatch.setattr(learn, "left_out_gains", lambda *_, **__: gains)
    monkeypatch.setattr(learn, "Judge", lambda *_: SimpleNamespace(gains=lambda *_: gains))
    monkeypatch.setattr(learn, "over_surrogates", lambda *_: [np.zeros((1, 3))])
    monkeypatch.setattr(learn, "effect_threshold", lambda *_: 10.0)
    monkeypatch.setattr(learn, "is_admissible", lambda *_: True)
    monkeypatch.setattr(learn, "_variable", lambda _: "position")
    monkeypatch.setattr(learn, "_effect", lambda _: None)
    monkeypatch.setattr(learn, "with_own_width", lambda *_: "curve")
    monkeypatch.setattr(learn, "_is_law", lambda _now, one, _joint, variable: one == variable)
    now: Any = SimpleNamespace(
        data=None,
        baseline=None,
        fit=None,
        products=None,
        accepted=[law_of],
        usual_power=lambda _: ROWS * usual_error**2,
    )
    pool: Any = SimpleNamespace(candidates=lambda _: [curve], placebo_candidates=lambda _: [])
    found = learn._best_beside(now, pool, 10.0)
    assert (found is not None) is learned
