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
