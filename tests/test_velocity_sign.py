"""The expected sign of a velocity against numerical integration, and what is assumed at rest."""

from __future__ import annotations

import numpy as np
import pytest

from physident.recordings.rests import Rests
from physident.recordings.velocity_sign import expected_sign, velocity_sign
from tests.exact_friction import STEEP, WIDTH, EstimatorsOwn


@pytest.mark.parametrize("v", [-0.3, -0.004, 0.0, 0.001, 0.02])
@pytest.mark.parametrize("half", [0.0, 1e-4, -0.005, 0.05])
@pytest.mark.parametrize("std", [1e-4, 0.003, 0.05])
def test_expected_sign_is_the_integral(v: float, half: float, std: float) -> None:
    """The mean of sgn over the velocities of a sample, each with the same normal error."""
    error = std * np.linspace(-8, 8, 4001)
    density = np.exp(-((error / std) ** 2) / 2)
    within = v + half * (np.arange(2001) - 1000) / 1000
    below = np.array([np.trapezoid(density * np.sign(x + error), error) for x in within]) / np.trapezoid(density, error)
    mean = np.trapezoid(below, dx=1 / 2000)
    assert float(expected_sign(np.array([v]), np.array([half]), std)[0]) == pytest.approx(mean, abs=2e-3)


def test_a_sure_velocity_has_its_sign() -> None:
    v = np.array([-0.5, -1e-6, 1e-6, 0.5])
    sign, spread = velocity_sign(v[None], np.zeros((1, 4)), np.zeros(1), None)
    np.testing.assert_allclose(sign[0], np.sign(v))
    np.testing.assert_allclose(spread, 0.0, atol=1e-9)


def _rest(before: float, after: float) -> tuple[np.ndarray, np.ndarray]:
    v = np.concatenate([np.full(5, before), np.zeros(40), np.full(5, after)])
    one = np.array([5]), np.array([45])
    rests = Rests(start=one[0], stop=one[1], before=np.array([before]), after=np.array([after]))
    sign, spread = velocity_sign(np.nan_to_num(v)[None], np.zeros((1, 50)), np.array([1e-3]), [rests])
    return sign[0], spread[0]


def test_friction_at_rest_passes_from_the_sign_before_to_the_sign_after() -> None:
    sign, spread = _rest(0.2, -0.2)
    assert (np.diff(sign[5:45]) < 0).all()
    assert sign[5] == pytest.approx(1, abs=0.05)
    assert sign[44] == pytest.approx(-1, abs=0.05)
    assert spread[25] == pytest.approx(3**-0.5, rel=0.05)  # that of a number anywhere between -1 and 1
    assert spread[:5].max() < 1e-6
    on, _ = _rest(0.2, 0.2)
    assert on[5] > 0.8
    assert abs(on[25]) < 0.1  # it lets go in between
    first, wide = _rest(np.nan, 0.2)
    assert abs(first[5]) < 0.05
    assert wide[5:40].min() > 0.3


def test_a_torque_of_one_instant_lies_within_the_spread() -> None:
    """An exact velocity crosses zero inside a sample: the instrument shows the sign of one instant, or the sample's mean."""
    half, v = 0.01, np.linspace(-0.015, 0.015, 3001)
    sign, spread = (one[0] for one in velocity_sign(v[None], np.full((1, len(v)), half), np.array([1e-9]), None))
    inside = np.abs(v) < half
    error = (np.sign(v) - sign)[inside]
    size = float(np.sqrt((spread[inside] ** 2).mean()))
    assert np.sqrt((error**2).mean()) <= size <= 2 * np.sqrt((error**2).mean())
    assert spread[np.abs(v) > 1.01 * half].max() < 1e-6


@pytest.mark.parametrize("width", [0.002, WIDTH, 0.1])
def test_recordings_of_exact_arms_have_the_same_sign(width: float) -> None:
    u = np.concatenate([width * np.linspace(-9, 9, 1001), np.linspace(-3, 3, 1001)])
    expected = expected_sign(u, np.zeros_like(u), STEEP * width)
    np.testing.assert_array_equal(EstimatorsOwn(width=width).direction(u), expected)
