"""The control of a change with many recordings: blocks of rows cannot become fewer than there are recordings."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from physident.diagnosis.grading.control import _JointFit
from physident.diagnosis.grading.scatter import Scatter


@pytest.mark.parametrize("recordings", [2, 8, 12])
def test_a_difference_is_judged_with_any_number_of_recordings(recordings: int) -> None:
    rows = 40
    segment = np.repeat(np.arange(recordings), rows)
    push = np.random.default_rng(recordings).standard_normal(len(segment))
    one = SimpleNamespace(segment=segment, kept_rate=10.0)
    fit = _JointFit(columns=(), torque=(), smooth=(), common=0, segment=segment, parts=(one,), shown=())  # pyright: ignore[reportArgumentType]
    scatter, alike = np.sqrt(len(segment)), Scatter(variance=0.0, count=recordings)  # of a sum of white noise
    assert fit._chance(0.1 * scatter, push, alike) > 0.5
    assert fit._chance(12 * scatter, push, alike) < 1e-3
    assert fit._chance(12 * scatter, push, Scatter(variance=36 * scatter**2, count=recordings)) > 0.05
