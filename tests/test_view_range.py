"""Vertical axes of a session: all of every curve, and two numbers beside it, for any curve."""

from __future__ import annotations

import numpy as np
import pytest

from physident.graphics.session.axis_ranges import MARGIN, MAX_TICKS, labelled_range


@pytest.mark.parametrize("seed", range(5))
def test_a_range_holds_its_curves_and_two_numbered_marks(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(200):
        size, middle = 10 ** rng.uniform(-3, 4), rng.normal()
        curves = [size * (middle + rng.uniform(-1, 1, 30)) for _ in range(2)]
        curves[0][3] = np.nan
        found = labelled_range(curves)
        assert found is not None
        low, high = found
        least, most = (float(f([f(c[np.isfinite(c)]) for c in curves])) for f in (min, max))
        assert low < least < most < high
        numbered = [
            step
            for step in 10.0 ** np.arange(-5, 6)
            if (high - low) / step <= (1 + 2 * MARGIN) * 2 * MAX_TICKS
            and np.floor(high / step) - np.ceil(low / step) >= 1
        ]
        assert numbered
        # what is added is less than a mark's distance, and that less than the curves' own length times ten over the dense
        assert high - low <= (1 + 2 * MARGIN) * ((most - least) + 2 * 10 * (most - least) / MAX_TICKS)


def test_nothing_to_show_has_no_range() -> None:
    assert labelled_range([]) is None
    assert labelled_range([np.full(4, np.nan)]) is None
    assert labelled_range([np.full(4, 2.0), np.array([np.nan])]) is None
    low, high = labelled_range([np.array([-50.0, 60.0])]) or (0.0, 0.0)
    assert low < -50 < 60 < 100 < high or low < -100 < 60 < high  # by hand: 0 alone is in between
