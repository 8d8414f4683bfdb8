"""Charts drawn inside a session: round ticks, points where their axes say, medians of bins."""

from __future__ import annotations

import numpy as np
import pytest

from physident.graphics.session.chart import HEIGHT, WIDTH, Axes, binned_median, decades, ticks


@pytest.mark.parametrize(("low", "high"), [(-1.3, 2.7), (0.0, 1e-4), (-4e5, 9e5), (99.0, 101.0)])
def test_ticks_are_round_few_and_inside(low: float, high: float) -> None:
    found = np.array(ticks(low, high))
    assert 3 <= len(found) <= 7
    assert low <= found.min()
    assert found.max() <= high
    steps = np.diff(found)
    np.testing.assert_allclose(steps, steps[0])
    digit = steps[0] / 10 ** np.floor(np.log10(steps[0] * (1 + 1e-9)))
    assert min(abs(digit - d) for d in (1, 2, 2.5, 5)) < 1e-6


def test_decades_are_one_two_and_five() -> None:
    np.testing.assert_allclose([10**v for v in decades(np.log10(3), np.log10(60))], [5, 10, 20, 50])


def test_points_stand_where_the_axes_say() -> None:
    x, y = np.array([-2.0, 0.0, 2.0]), np.array([1.0, 10.0, 100.0])
    places = Axes.about(x, y, logarithmic=True).place(x, y)
    np.testing.assert_allclose(places[1], [WIDTH / 2, HEIGHT / 2])  # the middle of either range
    assert (np.diff(places[:, 0]) > 0).all()
    assert (np.diff(places[:, 1]) < 0).all()  # the view's second axis points down
    assert (places >= 0).all()
    assert (places <= [WIDTH, HEIGHT]).all()


def test_axes_of_one_value_still_have_a_range() -> None:
    axes = Axes.about(np.zeros(4), np.full(4, np.nan))
    assert axes.x[0] < 0 < axes.x[1]
    assert axes.y[0] < axes.y[1]


def test_medians_follow_a_curve_through_outliers() -> None:
    rng = np.random.default_rng(0)
    x = rng.uniform(-1, 1, 4000)
    y = x**2 + 0.01 * rng.normal(size=4000)
    y[::20] += 50.0  # one in twenty is far off
    y[7] = np.nan
    at, middle = binned_median(x, y)
    assert len(at) == 24
    np.testing.assert_allclose(middle, at**2, atol=0.05)
