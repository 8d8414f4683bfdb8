"""The units of a sliding joint: measured in decimetres, the numbers of a motion and of what makes its force change as the units say."""

from __future__ import annotations

import re

import numpy as np
import pytest

import physident as pid
from physident.errors import InputError
from physident.estimation.estimate import as_estimate
from physident.recordings.signals import Signals
from physident.replay.replay import replay
from tests.robots import TREE

TIMES = 10.0  # a decimetre is a tenth of a metre
SIZES = ("kg", "N", "m", "s", "rad")


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    """An arm whose first joint slides and whose others turn."""
    path = tmp_path_factory.mktemp("tree") / "tree.urdf"
    path.write_text(TREE)
    return pid.load_robot(path)


def length(unit: str, power: float = 1.0) -> float:
    """The power of the metre in a unit of newtons, seconds and metres; a kilogram is N s^2/m."""
    unit = unit.replace("^a", f"^{power:g}")
    total, sign = 0.0, 1.0
    for token in re.findall(r"\([^)]*\)(?:\^[\d.]+)?|[A-Za-z]+(?:\^[\d.]+)?|/", unit):
        if token == "/":
            sign = -1.0
            continue
        body, _, exponent = token.rpartition("^") if "^" in token else (token, "", "1")
        inner = length(body[1:-1]) if body.startswith("(") else {"m": 1.0, "kg": -1.0}.get(body, 0.0)
        assert body.startswith("(") or body in SIZES, unit
        total += sign * float(exponent) * inner
    return total


def moving(scale: float, n: int) -> Signals:
    """A motion that does not turn back, and is at no rest, with positions in units of 1 / scale metres."""
    t = np.linspace(0.0, 1.0, 50)[:, None] * np.ones(n)
    return Signals(
        time=t[:, 0],
        q=scale * (0.3 + t + 0.2 * t**2),
        v=scale * (1 + 0.4 * t),
        a=np.full_like(t, scale * 0.4),
        rate=50.0,
    )


@pytest.mark.parametrize(
    ("name", "power", "shape"),
    [
        ("viscous_friction", 1.0, {}),
        ("friction_asymmetry", 1.0, {}),
        ("nonlinear_viscous_friction", 2.0, {"exponent": (2.0,)}),
        ("nonlinear_viscous_friction", 0.5, {"exponent": (0.5,)}),
        ("coulomb_friction", 1.0, {"smoothing": 0.0}),
        ("joint_spring", 1.0, {}),
        ("rotor_inertia", 1.0, {}),
        ("torque_offset", 1.0, {}),
    ],
)
def test_what_a_unit_makes_changes_with_the_measure_of_length_as_it_says(
    tree: pid.Robot, name: str, power: float, shape: dict
) -> None:
    effect = pid.CATALOGUE[name](joints=(1,), **shape)
    (unit,) = {column.unit for column in effect.columns(tree)}
    metres, decimetres = (effect.values(tree, moving(scale, tree.n)) for scale in (1.0, TIMES))
    np.testing.assert_allclose(decimetres, metres * TIMES ** -length(unit, power), rtol=1e-9)


def test_no_unit_of_a_sliding_joint_is_that_of_a_turning_one(tree: pid.Robot) -> None:
    for effect in pid.CATALOGUE.values():
        if effect.name in (
            "payload",
            "contact",
            "gravity_tilt",
            "gravity_magnitude",
            "time_delay",
            "rigid_body",
            "link_inertia",
        ):
            continue  # of the whole arm, or of links
        for place in effect.places(tree):
            concrete = effect.at_grid_middle(tree, place or None)
            for column in concrete.columns(tree):
                slides = column.joint == 1
                assert not (slides and re.search(r"rad|(?<!/\()N m(?! ?/N)", column.unit)), (effect.name, column)


def test_tables_name_both_units_where_some_joints_turn_and_some_slide(tree: pid.Robot) -> None:
    effects = pid.make_effects(("rigid_body", "viscous_friction", "coulomb_friction"))
    friction = np.concatenate([tree.nominal, np.full(tree.n, 2.0), np.full(tree.n, 1.0)])
    motions = [pid.random_trajectory(tree, seed=seed, duration=10.0) for seed in (1, 2)]
    runs = [pid.simulate(pid.Model(tree, effects, friction), motion) for motion in motions]
    estimate = pid.identify(tree, runs[0], effects)
    units = {(c.effect, c.joint): c.unit for c in estimate.model.columns}
    assert [units["viscous_friction", j] for j in (1, 2)] == ["N s/m", "N m s/rad"]
    assert "[N s/m|N m s/rad]" in str(estimate)
    score = pid.validate(estimate, runs[1])
    assert "rms [N m|N]" in str(score)
    header, first = str(score).splitlines()[1:3]
    number = f"{score.rms[0]:.4g}"
    assert header.index("[N m|N]") + len("[N m|N]") == first.index(number) + len(number)


def test_a_joint_that_slides_is_shown_in_metres_where_the_table_says_radians(tree: pid.Robot) -> None:
    effects = pid.make_effects(("rigid_body", "viscous_friction"))
    model = pid.Model(tree, effects, np.concatenate([tree.nominal, np.full(tree.n, 2.0)]))
    run = pid.simulate(model, pid.random_trajectory(tree, seed=1, duration=10.0))
    assert "\njoint 1 slides: m, m/s, N\n" in str(pid.inspect_recording(run, tree))
    assert "slides" not in str(pid.inspect_recording(run))
    replayed = replay(as_estimate(model, pid.Filter()), None, [run], "physident", 0.1).replay
    assert "\njoint 1 slides: mm, mm/s, N\n" in str(replayed)
    other = pid.load_robot("ur5")
    with pytest.raises(InputError, match=f"{tree.n} joints, but robot ur5 has 6"):
        pid.inspect_recording(run, other)
    assert other.units_where_it_slides("rad") == ""
