"""A gain of a joint's torque is refuted by torque that leaks from others only where the leaks take most of what the gain leaves."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from physident.diagnosis.rivals import imitators


@pytest.mark.parametrize(
    ("gain_leaves", "leaks_leave", "holds"),
    [(24.2, 16.2, True), (24.2, 8.0, False), (344.6, 0.3, False), (64.9, 73.9, True)],
)
def test_leaks_refute_a_gain_where_they_take_most_of_what_it_leaves(
    gain_leaves: float, leaks_leave: float, holds: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Shares of all joints' torques always fit a little better than one number, as where friction differs from day to day."""
    blocks = np.ones((9, 1)) / 9
    gain, leaks = SimpleNamespace(count=1), SimpleNamespace(count=5)
    cost = {1: gain_leaves * blocks, 5: leaks_leave * blocks}
    hypothesis: Any = SimpleNamespace(
        columns=lambda *_: gain,
        fit=SimpleNamespace(weights=np.ones(1)),
        left_out_fits=SimpleNamespace(squares_of_blocks=lambda columns, _: cost[columns.count]),
        left_out_squares=350.0 * blocks,
        problem=SimpleNamespace(taken_off_squares=np.zeros(1)),
    )
    monkeypatch.setattr(imitators, "refine_shape", lambda *_: None)
    monkeypatch.setattr(imitators, "_with_leaks", lambda *_: leaks)
    candidate: Any = SimpleNamespace()
    assert imitators.holds_against_leaks(hypothesis, candidate) == holds
