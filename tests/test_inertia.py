"""Ten link parameters, their pseudo-inertia, and what makes them a body."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from physident.robots.inertia import inertia_tensor, link_parameters, nearest_physical, pseudo_inertia, violations

numbers = hnp.arrays(float, 10, elements=st.floats(-10, 10))
clouds = st.integers(0, 10_000).map(np.random.default_rng)


def of_points(mass: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Link parameters (10,) of point masses (K,) [kg] at places (K, 3) [m], straight from the definitions."""
    first = mass @ place
    tensor = np.sum([m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(mass, place, strict=True)], axis=0)
    return np.array([mass.sum(), *first, *tensor[np.tril_indices(3)]])  # Ixx, Ixy, Iyy, Ixz, Iyz, Izz


@given(numbers)
def test_pseudo_inertia_round_trip(phi: np.ndarray) -> None:
    P = pseudo_inertia(phi)
    np.testing.assert_array_equal(P, P.T)
    np.testing.assert_allclose(link_parameters(P), phi, atol=1e-12)


@given(clouds)
def test_pseudo_inertia_is_the_second_moment_of_mass(rng: np.random.Generator) -> None:
    mass, place = rng.uniform(0.1, 2, 7), rng.normal(size=(7, 3))
    phi = of_points(mass, place)
    ones = np.column_stack([place, np.ones(7)])
    np.testing.assert_allclose(pseudo_inertia(phi), (ones.T * mass) @ ones, atol=1e-12)
    np.testing.assert_allclose(inertia_tensor(phi), inertia_tensor(phi).T)
    assert violations(phi) == []


@given(numbers)
def test_violations_agree_with_the_eigenvalues(phi: np.ndarray) -> None:
    lowest = np.linalg.eigvalsh(pseudo_inertia(phi))[0]
    if abs(lowest) > 1e-6:
        assert bool(violations(phi)) == (lowest < 0)


@given(numbers, clouds)
def test_nearest_physical_is_physical_and_no_other_body_is_nearer(phi: np.ndarray, rng: np.random.Generator) -> None:
    floor = 1e-6
    near = pseudo_inertia(nearest_physical(phi, floor))
    assert np.linalg.eigvalsh(near)[0] >= floor * (1 - 1e-6) - 1e-12
    # a projection onto a convex set: the way back makes no acute angle with the way to any other member of the set
    for _ in range(5):
        A = rng.normal(size=(4, 4))
        member = A @ A.T + floor * np.eye(4)
        assert np.sum((pseudo_inertia(phi) - near) * (member - near)) <= 1e-9 * (1 + np.abs(phi).max()) ** 2


def test_a_body_stays_as_it_is() -> None:
    rng = np.random.default_rng(0)
    phi = of_points(rng.uniform(0.1, 2, 7), rng.normal(size=(7, 3)))
    np.testing.assert_allclose(nearest_physical(phi), phi, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("phi", "condition", "cause"),
    [
        ([1, 0, 0, 0, 0.0012, 0, 0.0012, 0, 0, 0.009], "triangle inequality", "a slipped decimal?"),
        ([1, 0, 0, 0, 0.001, 0, 0.001, 0, 0, 0.1], "triangle inequality", ""),
        ([2, 1, 0, 0, 0.01, 0, 0.02, 0, 0, 0.02], "negative", "given about the wrong point"),
        ([-1, 0, 0, 0, 1, 0, 1, 0, 0, 1], "mass -1 kg", ""),
    ],
)
def test_the_broken_condition_and_its_likely_cause(phi: list[float], condition: str, cause: str) -> None:
    (said,) = violations(np.array(phi, dtype=float))
    assert condition in said
    assert ("?" in said) == bool(cause)
    assert cause in said
