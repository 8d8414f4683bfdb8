"""Vertical axes of a session fit the curves, and the title of a plot has what the viewer does not label."""

from __future__ import annotations

import re

import numpy as np
import pytest

from physident.graphics.session.axis_ranges import MARGIN, extent, in_title, with_margin


@pytest.mark.parametrize("seed", range(5))
def test_a_range_holds_its_curves_and_little_more(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(200):
        size, middle = 10 ** rng.uniform(-3, 4), rng.normal()
        curves = [size * (middle + rng.uniform(-1, 1, 30)) for _ in range(2)]
        curves[0][3] = np.nan
        found = extent(curves)
        assert found is not None
        assert found == (np.nanmin(curves), np.nanmax(curves))
        low, high = with_margin(found)
        assert low < found[0] < found[1] < high
        assert high - low == pytest.approx((1 + 2 * MARGIN) * (found[1] - found[0]))
        # the title has both ends, to a tenth of the power of ten below the length
        said = [float(x) for x in re.findall(r"-?[\d.]+(?:e[+-]\d+)?", in_title(found, "N m"))]
        np.testing.assert_allclose(said, found, atol=0.051 * (found[1] - found[0]))


def test_a_plot_with_a_legend_has_room_above() -> None:
    assert with_margin((0.0, 1.0), above=0.5) == pytest.approx((-MARGIN, 1.0 + MARGIN + 0.5))


def test_nothing_to_show_has_no_range() -> None:
    assert extent([]) is None
    assert extent([np.full(4, np.nan)]) is None
    assert extent([np.full(4, 2.0), np.array([np.nan])]) is None
    assert in_title(None, "N m") == "[N m]"
    assert in_title((-5.84, 6.02), "N m") == "-6 to 6 N m"
