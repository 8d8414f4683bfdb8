"""What lies about reversals is told, what lies anywhere is not; a curve over a quantity explains what its bins can."""

from __future__ import annotations

import numpy as np
import pytest

from physident.diagnosis.remainder.shares import share_of_curve, share_of_slowest, slowest_in_words

ROWS = 4000


@pytest.fixture(scope="module")
def rng() -> np.random.Generator:
    return np.random.default_rng(11)


def test_what_an_arm_does_about_its_reversals_lies_there(rng: np.random.Generator) -> None:
    """A pendulum swings; a stick of its friction lasts as long as it is slower than a tenth of its fastest: in 6.4 % of the time, arcsin(0.1) 2/pi."""
    v = np.cos(np.linspace(0.0, 80.0, ROWS))
    stick = np.where(np.abs(v) < 0.1, np.sign(rng.standard_normal(ROWS)), 0.0)
    assert share_of_slowest(stick, v) == pytest.approx(1.0)
    beside = share_of_slowest(stick + 0.1 * rng.standard_normal(ROWS), v)
    assert beside == pytest.approx((0.064 + 0.2 * 0.01) / (0.064 + 0.01), rel=0.05)
    assert f"{100 * beside:.0f} % of it" in slowest_in_words(beside)


def test_noise_lies_there_for_a_fifth_and_is_not_told(rng: np.random.Generator) -> None:
    v = np.cos(np.linspace(0.0, 80.0, ROWS))
    share = share_of_slowest(rng.standard_normal(ROWS), v)
    assert share == pytest.approx(0.2, abs=0.03)
    assert slowest_in_words(share) == ""


def test_a_joint_that_stands_for_long_has_a_fifth_of_what_it_leaves_there(rng: np.random.Generator) -> None:
    assert share_of_slowest(rng.standard_normal(ROWS), np.zeros(ROWS)) == pytest.approx(0.2, abs=0.03)


def test_a_curve_explains_what_follows_it_and_no_noise(rng: np.random.Generator) -> None:
    x = rng.uniform(-1, 1, ROWS)
    noise = rng.standard_normal(ROWS)
    assert share_of_curve(noise, x, ROWS) < 0.01
    # a line over ten bins of equal width leaves a hundredth of its variance inside them
    assert share_of_curve(np.sqrt(3) * x + noise, x, ROWS) == pytest.approx(0.5 * 0.99, abs=0.03)
