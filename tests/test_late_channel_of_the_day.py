"""A channel that has become late is no friction of the day, however much of its torque other friction could make."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from physident.diagnosis.usual import as_usual
from physident.effects.catalogue import CATALOGUE


@pytest.mark.parametrize("late", ["torque_delay", "time_delay"])
def test_a_late_channel_is_no_friction_of_the_day(late: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where friction could make all of both torques, only the one of friction is usual: that more than friction lags was seen before."""
    joints = () if late == "time_delay" else (1,)
    dry = ("coulomb_friction", (1,))
    accepted = [
        SimpleNamespace(candidate=SimpleNamespace(key=(late, joints), joints=joints), effect=CATALOGUE[late]()),
        SimpleNamespace(candidate=SimpleNamespace(key=dry, joints=(1,)), effect=CATALOGUE[dry[0]]()),
    ]
    fit = SimpleNamespace(sigma=np.ones(1))
    hypothesis: Any = SimpleNamespace(accepted=accepted, problem=None, fit=fit, torque_of=lambda _: np.ones((4, 1)))
    monkeypatch.setattr(as_usual, "compared_rows", lambda _: np.ones(4, dtype=bool))
    monkeypatch.setattr(as_usual, "is_shown_by_comparison", lambda *_: True)
    monkeypatch.setattr(as_usual, "moved_friction", lambda _: np.zeros((4, 1)))
    made = as_usual._Change(power=4.0, made=4.0, size=0.01, offset=0.0)
    monkeypatch.setattr(as_usual, "_made_of_friction", lambda *_, **__: made)
    usual: Any = SimpleNamespace(parts=2, joint=0.04, arm=0.03, offset=0.01, recordings=5)
    assert set(as_usual.differ_as_usual(hypothesis, usual)) == {dry}
