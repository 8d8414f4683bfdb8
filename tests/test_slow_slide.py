"""What a slide has of lengths and speeds is millimetres: friction of a slow feed that changed is named with its size."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import physident as pid

pytestmark = pytest.mark.slow

Array = NDArray[np.float64]
FEED = """<robot name="feed"><link name="bed"/>
  <link name="carriage"><inertial><mass value="12"/><origin xyz="0 0 0.04"/>
    <inertia ixx="0.05" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="head"><inertial><mass value="3"/><origin xyz="0 0.06 0"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="feed" type="prismatic"><parent link="bed"/><child link="carriage"/><axis xyz="1 0 0"/>
    <limit lower="-0.1" upper="0.1" effort="200" velocity="0.1"/></joint>
  <joint name="tilt" type="revolute"><parent link="carriage"/><child link="head"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" effort="20" velocity="3"/></joint></robot>"""
CARRIED, HEAD, ARM = 15.0, 3.0, 0.06  # kg on the slide, kg of the head and m from its axis to its middle
SLIDES, OIL = 14.0, 90.0  # N and N s/m of the carriage on its bed
TURN = 1e-4  # m/s: any instrument's velocity is rougher
ORDINARY = ("rigid_body", "viscous_friction", "coulomb_friction")
BOUND, SHEARS = 6.0, (0.04e-3, 0.09e-3, 0.14e-3, 0.19e-3)  # N of parallel seals, and after how many metres each slips
CLINGS, FILM = 5.0, 4.2e-3  # N that a dry bed adds, and m/s by which the oil has lifted the carriage off it
COGS, SCREW = 2.4, 5e-3  # N, and m of carriage for a turn of the screw


def sealed(x: Array, v: Array) -> Array:
    """Seals that shear with the carriage until each slips (Maxwell slip), N."""
    held, total = np.zeros(len(SHEARS)), np.zeros(len(x))
    for i in range(1, len(x)):
        held = np.clip(held + x[i] - x[i - 1], -np.array(SHEARS), SHEARS)
        total[i] = BOUND * np.mean(held / SHEARS)
    return total


def clinging(x: Array, v: Array) -> Array:
    """The dry part of mixed lubrication, N."""
    return CLINGS * np.clip(v / TURN, -1, 1) * np.exp(-((v / FILM) ** 2))


def cogging(x: Array, v: Array) -> Array:
    """A bent screw, N."""
    return COGS * np.cos(2 * np.pi * x / SCREW + 0.7)


def freely(x: Array, v: Array) -> Array:
    """Nothing more than before, N."""
    return np.zeros(len(x))


def recorded(seed: int, law: Callable[[Array, Array], Array] = freely) -> pid.Recording:
    """A carriage that creeps to and fro while its head tilts; forces of the rigid bodies in closed form."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 60.0, 0.005)
    omega, phase = rng.uniform(0.3, 1.6, (4, 2)), rng.uniform(0, 2 * np.pi, (4, 2))
    angle = time[:, None, None] * omega + phase
    size = np.array([0.004, 0.3])
    q, v, a = (size * part.sum(axis=1) for part in (np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle)))
    force = CARRIED * a[:, 0] + OIL * v[:, 0] + SLIDES * np.clip(v[:, 0] / TURN, -1, 1) + law(q[:, 0], v[:, 0])
    tilt = (0.02 + HEAD * ARM**2) * a[:, 1] + HEAD * ARM * 9.81 * np.cos(q[:, 1])
    tilt = tilt + 0.2 * v[:, 1] + 0.3 * np.clip(v[:, 1] / 1e-3, -1, 1)
    noise = rng.standard_normal((len(time), 2)) * (0.4, 0.02)
    return pid.Recording.from_arrays(time, q, dq=v, effort=np.column_stack([force, tilt]) + noise, source=f"{seed}")


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> pid.Estimate:
    path = tmp_path_factory.mktemp("feed") / "feed.urdf"
    path.write_text(FEED)
    return pid.identify(pid.load_robot(path), [recorded(1), recorded(2)], pid.make_effects(ORDINARY))


@pytest.mark.parametrize(
    ("law", "name", "shape", "low", "high"),
    [
        (sealed, "presliding_hysteresis", "distance", SHEARS[0], SHEARS[-1]),
        (clinging, "stribeck_friction", "velocity", 0.8 * FILM, 1.2 * FILM),
        (cogging, "torque_ripple", "order", 2 * np.pi / SCREW * 0.999, 2 * np.pi / SCREW * 1.001),
    ],
)
def test_what_changed_on_a_slow_slide_is_named_with_its_length_or_speed(
    model: pid.Estimate, law: Callable[[Array, Array], Array], name: str, shape: str, low: float, high: float
) -> None:
    answer = pid.diagnose_motion(model, [recorded(3, law), recorded(4, law)])
    (cause,) = [one for one in answer.findings if one.grade == "cause"]
    assert (cause.effect, cause.joints) == (name, (1,))
    (found,) = [value for value in cause.parameters if value.name == shape]
    assert low <= found.value <= high
    assert not found.at_end


def test_a_slide_that_creeps_is_known_and_an_unchanged_one_is_not_accused(model: pid.Estimate) -> None:
    values = {column.name: value for column, value in zip(model.model.columns, model.theta, strict=True)}
    assert values["coulomb_friction_1"] == pytest.approx(SLIDES, rel=0.02)
    assert values["viscous_friction_1"] == pytest.approx(OIL, rel=0.15)
    assert all(one.grade == "hint" for one in pid.diagnose_motion(model, [recorded(5), recorded(6)]).findings)
