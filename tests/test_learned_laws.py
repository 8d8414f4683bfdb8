"""Which law keeps its name before a learned curve: one that takes as much as values are asked to be known, and that the arm can have."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from physident.diagnosis.learned import learn

# squared shares: a law whose torque is 10 % of the curve's RMS away takes 99 % of its power, one that is 20 % away 96 %
NEAR, FAR = 1 - 0.10**2, 1 - 0.20**2


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
    monkeypatch.setattr(learn, "laws_of_joint", lambda _rest, _joints: list(shares))
    monkeypatch.setattr(learn, "shares_of_curve", lambda _rest, _curve, laws: [shares[law] for law in laws])
    monkeypatch.setattr(learn, "is_admissible", lambda _rest, law: law not in impossible)
    monkeypatch.setattr(learn, "refine_shape", lambda _rest, law: law)
    curve: Any = SimpleNamespace(joints=(1,))
    rest: Any = SimpleNamespace()
    found = learn._law_of_its_shape(rest, curve)
    assert (None if found is None else found.effect) == named
