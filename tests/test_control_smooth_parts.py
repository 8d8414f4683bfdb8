"""What a function of position or velocity explains in all recordings is taken off before a change is sized."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

import physident as pid
from physident.diagnosis.grading.control import _JointFit
from physident.diagnosis.grading.smooth_parts import SmoothParts, smooth_parts
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.estimation.identify import prepare_all
from physident.recordings.signals import Filter, Signals
from tests.serial_arms import ARMS, urdf

Array = NDArray[np.float64]
FILTER = Filter(8.0)


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[Signals], list[SmoothParts], Array, Array]:
    """Signals of two joints, the parts of each, and position and velocity of joint 1 in the rows that are kept."""
    path = tmp_path_factory.mktemp("smooth") / "two.urdf"
    path.write_text(urdf(ARMS["two"]))
    robot, time, runs = pid.load_robot(path), np.arange(0.0, 40.0, 0.008), []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        omega, phase = rng.uniform(0.5, 3.0, (4, 2)), rng.uniform(0, 2 * np.pi, (4, 2))
        angle = time[:, None, None] * omega + phase
        q, v = (0.4 * part.sum(axis=1) for part in (np.sin(angle), omega * np.cos(angle)))
        runs.append(pid.Recording.from_arrays(time, q, dq=v, effort=rng.standard_normal(q.shape), source=f"{seed}"))
    signals = prepare_all(robot, runs, FILTER)
    rows = [len(state_rows(robot, signals[:2])), len(state_rows(robot, signals[2:]))]
    weights = [np.ones((count, 2)) for count in rows]
    made = smooth_parts(robot, [(signals[:2], weights[0]), (signals[2:], weights[1])], FILTER)
    states = [state_rows(robot, some) for some in (signals[:2], signals[2:])]
    q, v = np.concatenate(states).T
    return signals, made, q, v


def state_rows(robot: pid.Robot, signals: list[Signals]) -> Array:
    """Position and velocity (M, 2) of joint 1, filtered and kept as every column is: those of a spring and of viscous friction."""
    from physident.dynamics.regressor import build_regressor

    regressor = build_regressor(robot, pid.make_effects(["joint_spring", "viscous_friction"]), signals, FILTER)
    rows = regressor.joints[0]
    names = [regressor.columns[c].name for c in rows.columns]
    return np.column_stack([rows.values[:, names.index(f"{name}_1")] for name in ("joint_spring", "viscous_friction")])


def share_left(part: SmoothParts, rows: Array) -> float:
    rows = 10 * rows / rows.std()  # well above what is left
    return float(np.sum(part.taken_off(rows) ** 2) / np.sum(rows**2))


def test_any_function_of_position_and_one_of_velocity_are_taken_off_and_nothing_else(
    parts: tuple[list[Signals], list[SmoothParts], Array, Array],
) -> None:
    _, (first, _), q, v = parts
    bent = np.maximum(0.0, q - 0.4) ** 2 + 0.2 * np.sin(6 * q)
    assert share_left(first, bent - bent.mean()) < 0.02
    assert share_left(first, 2 * v / (1 + v**2)) < 0.02
    assert share_left(first, q * v) > 0.7
    assert share_left(first, np.random.default_rng(0).standard_normal(len(q))) > 0.8


def test_a_change_is_sized_beside_what_no_model_has(
    parts: tuple[list[Signals], list[SmoothParts], Array, Array],
) -> None:
    """A torque of which half is there after, beside a cable that both sets have: the cable alone would change its size."""
    _, (first, _), q, v = parts
    after = np.arange(len(q)) >= len(q) // 2
    effect, rng, found, plain = q**2 * after, np.random.default_rng(1), [], []
    for size in (0.0, 1.0):
        cable = 8 * np.maximum(0.0, q - 0.2) ** 2 * np.where(q > 0, 1.0, 0.3)
        torque = cable + size * effect + 0.1 * rng.standard_normal(len(q))
        A = np.column_stack([effect, np.ones(len(q)), q, v])
        for rows, into in ((lambda x: x, plain), (lambda x: first.taken_off(x / 0.1) * 0.1, found)):
            into.append(np.linalg.lstsq(rows(A), rows(torque))[0][0])
    np.testing.assert_allclose(found, [0.0, 1.0], atol=0.03)
    assert np.abs(np.subtract(plain, [0.0, 1.0])).max() > 0.03


def test_the_control_sizes_a_change_beside_them(parts: tuple[list[Signals], list[SmoothParts], Array, Array]) -> None:
    """The same cable and change, in the fit of both sets that a diagnosis makes."""
    _, (first, _), q, v = parts
    after = np.arange(len(q)) >= len(q) // 2
    cable = 8 * np.maximum(0.0, q - 0.2) ** 2 * np.where(q > 0, 1.0, 0.3)
    effect, noise = q**2 * after, 0.1
    torque = cable + effect + noise * np.random.default_rng(1).standard_normal(len(q))
    columns = np.column_stack([np.ones(len(q)), q, v, effect]) / noise
    fit = _JointFit(
        columns=(columns,),
        torque=(torque / noise,),
        smooth=(first,),
        common=3,
        segment=after.astype(int),
        parts=cast(Any, ()),
        shown=(),
    )
    normal, slope = fit.products
    assert (pseudo_inverse(normal) @ slope)[-1] == pytest.approx(1.0, abs=0.03)
