"""Base parameters: their number, their grouping, and that torques need nothing else."""

from __future__ import annotations

import tomllib
from importlib import resources

import numpy as np
import pytest

import physident as pid
from physident.identifiability.base_parameters import random_motion, select_base
from physident.robots.dh import urdf_from_table
from tests.robots import TREE


def _half(joints: slice, gravity: tuple[float, float, float]) -> pid.Robot:
    table = tomllib.loads(resources.files("physident").joinpath("robots", "ur5.toml").read_text())
    return pid.Robot("half", urdf_from_table(table | {"joints": table["joints"][joints]}), gravity)


def _stacked(robot: pid.Robot, effects: tuple[pid.Effect, ...], seed: int) -> np.ndarray:
    states = random_motion(robot, seed, count=60)
    return np.concatenate([e.regressor(robot, states) for e in effects], axis=2).reshape(60 * robot.n, -1)


def test_whole_ur5_has_36(ur5: pid.Robot) -> None:
    base = pid.find_base_parameters(ur5, pid.make_effects(["rigid_body"]))
    assert base.r == 36
    # an independent count: the rank of the regressor by singular values
    Y = _stacked(ur5, pid.make_effects(["rigid_body"]), seed=9)
    size = np.linalg.norm(Y, axis=0)
    assert np.linalg.matrix_rank(Y[:, size > 1e-9] / size[size > 1e-9]) == 36
    accepted, rejected = base.rank_gap
    assert accepted > 1e-2
    assert rejected < 1e-12


@pytest.mark.parametrize(
    ("joints", "gravity", "count"),
    [
        (slice(0, 3), (0.0, 0.0, -9.81), 15),  # base, shoulder, elbow as mounted
        (slice(3, 6), (0.0, 0.0, -9.81), 15),  # the wrist with gravity along the axis of joint 4, as in the thesis
        (slice(3, 6), (0.0, -9.81, 0.0), 17),  # the wrist as mounted: joint 4's axis is level
    ],
)
def test_halves_of_the_thesis(joints: slice, gravity: tuple[float, float, float], count: int) -> None:
    assert pid.find_base_parameters(_half(joints, gravity), pid.make_effects(["rigid_body"])).r == count


@pytest.mark.parametrize("which", ["ur5", "tree"])
def test_grouping_keeps_every_torque(which: str, ur5: pid.Robot) -> None:
    robot = ur5 if which == "ur5" else pid.Robot("tree", TREE)
    effects = pid.make_effects(["rigid_body", "rotor_inertia", "viscous_friction", "torque_offset"])
    base = pid.find_base_parameters(robot, effects)
    Y = _stacked(robot, effects, seed=11)  # other states than those the grouping was found on
    np.testing.assert_allclose(Y, Y[:, base.independent] @ base.grouping, atol=1e-9 * np.abs(Y).max())
    theta = np.random.default_rng(0).normal(size=len(base.columns))
    np.testing.assert_allclose(base.values(theta), base.grouping @ theta, rtol=1e-12)


def test_expressions_say_what_the_matrix_says(ur5: pid.Robot) -> None:
    base = pid.find_base_parameters(ur5, pid.make_effects(["rigid_body"]))
    names = {column.name: i for i, column in enumerate(base.columns)}
    for row, text in enumerate(base.expressions()):
        rebuilt = np.zeros(len(names))
        sign, factor = 1.0, 1.0
        for word in text.split():
            if word in "+-":
                sign, factor = (1.0 if word == "+" else -1.0), 1.0
            elif word in names:
                rebuilt[names[word]] = sign * factor
            else:
                factor = float(word)
        np.testing.assert_allclose(rebuilt, base.grouping[row], atol=1e-6)
    assert base.expressions()[0].startswith("Izz_1 + Iyy_2 + 0.180625 m_3")  # 0.425^2: the upper arm's length squared


def test_late_column_survives_many_dependent_ones() -> None:
    """The noise of dependent columns must not hide an independent one at the end, as |R_ii| of a plain QR can."""
    rng = np.random.default_rng(1)
    first = rng.normal(size=(12, 3))
    R = np.column_stack([first, first @ rng.normal(size=(3, 8)), rng.normal(size=12)])
    R = np.asarray(np.linalg.qr(R, mode="r"))
    columns = tuple(pid.Column(f"c{i}", "1", 1, "made") for i in range(12))
    assert select_base(R, columns).independent.tolist() == [0, 1, 2, 11]


def test_zero_regressor_is_refused() -> None:
    with pytest.raises(pid.InputError, match="zero in every column"):
        select_base(np.zeros((3, 3)), tuple(pid.Column(f"c{i}", "1", 1, "made") for i in range(3)))
