"""Wrong set-ups are named with their joints, healthy ones are left alone; the statistics equal independent computations."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

import physident as pid
from physident.setup_checks.jackknife import LEVEL, jackknife
from physident.setup_checks.joint_fit import moments_of, own_unexplained, unexplained
from physident.setup_checks.rows import rows_of
from tests.conftest import UR5_GAINS, UR10E_COLUMNS, UR10E_GAINS

Array = NDArray[np.float64]
Runs = list[pid.Recording]
ALL = (1, 2, 3, 4, 5, 6)


def kinds(robot: pid.Robot | None, runs: Runs) -> list[tuple[str, tuple[int, ...]]]:
    return [(found.kind, found.joints) for found in pid.check_setup(robot, runs)]


def each(runs: Runs, change: Callable[[pid.Recording], pid.Recording]) -> Runs:
    return [change(run) for run in runs]


def swapped(i: int, j: int, n: int = 6) -> list[int]:
    order = list(range(n))
    order[i - 1], order[j - 1] = j - 1, i - 1
    return order


@pytest.fixture(scope="module")
def runs(healthy_runs: Runs) -> Runs:
    return healthy_runs[:2]


def test_healthy_recordings_are_left_alone(ur5: pid.Robot, healthy_runs: Runs) -> None:
    for chosen in (*([run] for run in healthy_runs), healthy_runs):
        assert kinds(ur5, chosen) == []
        assert kinds(None, chosen) == []


def test_all_signs(ur5: pid.Robot, runs: Runs) -> None:
    (found,) = pid.check_setup(ur5, each(runs, lambda r: replace(r, effort=-r.effort)))
    assert (found.kind, found.joints, found.void) == ("effort_sign", ALL, True)
    assert "all joints has the wrong sign" in found.statement


@pytest.mark.parametrize("joint", ALL)
def test_the_sign_of_one_joint(ur5: pid.Robot, runs: Runs, joint: int) -> None:
    sign = np.where(np.arange(6) == joint - 1, -1.0, 1.0)
    assert kinds(ur5, each(runs, lambda r: replace(r, effort=sign * r.effort))) == [("effort_sign", (joint,))]


@pytest.mark.parametrize("pair", [(i, j) for i in ALL for j in ALL if i < j])
def test_two_efforts_swapped(ur5: pid.Robot, runs: Runs, pair: tuple[int, int]) -> None:
    wrong = each(runs, lambda r: replace(r, effort=r.effort[:, swapped(*pair)]))
    assert kinds(ur5, wrong) == [("effort_order", pair)]


def test_efforts_reversed(ur5: pid.Robot, runs: Runs) -> None:
    (found,) = pid.check_setup(ur5, each(runs, lambda r: replace(r, effort=r.effort[:, ::-1].copy())))
    assert found.kind == "effort_order"
    assert "reverse order" in found.statement


@pytest.mark.parametrize("pair", [(1, 2), (2, 3), (1, 3)])
def test_joints_swapped_in_all_columns(ur5: pid.Robot, runs: Runs, pair: tuple[int, int]) -> None:
    """As drivers do that sort joints by name: elbow before shoulder."""
    order = swapped(*pair)

    def change(r: pid.Recording) -> pid.Recording:
        return replace(r, q=r.q[:, order], dq=None if r.dq is None else r.dq[:, order], effort=r.effort[:, order])

    assert kinds(ur5, each(runs, change)) == [("joint_order", pair)]


@pytest.mark.parametrize("joint", [2, 3])
@pytest.mark.parametrize(
    ("turn", "zero", "says"),
    [
        (-1.0, 0.0, "turns the other way"),
        (1.0, np.pi / 2, "90 degrees above"),
        (1.0, -np.pi / 2, "90 degrees below"),
        (1.0, np.pi, "half a turn"),
    ],
)
def test_the_zero_and_the_direction_of_one_joint(
    ur5: pid.Robot, runs: Runs, joint: int, turn: float, zero: float, says: str
) -> None:
    """Joints that carry the arm's weight; a wrist's weight shows no more than its friction."""
    here = np.arange(6) == joint - 1
    sign = np.where(here, turn, 1.0)

    def change(r: pid.Recording) -> pid.Recording:
        dq = None if r.dq is None else sign * r.dq
        return replace(r, q=sign * r.q + here * zero, dq=dq, effort=sign * r.effort)

    (found,) = pid.check_setup(ur5, each(runs, change))
    if found.kind == "gravity_direction":  # an arm whose second joint is half a turn off is an arm that hangs
        assert (joint, zero) == (2, np.pi)
        assert found.rivals == ("joint 2 is recorded half a turn from where it is described",)
        return
    assert (found.kind, found.joints, found.void) == ("joint_place", (joint,), True)
    assert says in found.statement


@pytest.mark.parametrize(
    ("factor", "kind"), [(0.1, "motor_current"), (0.01, "motor_torque"), (1000.0, "effort_unit"), (2.5, "description")]
)
def test_efforts_of_another_size(ur5: pid.Robot, runs: Runs, factor: float, kind: str) -> None:
    (found,) = pid.check_setup(ur5, each(runs, lambda r: replace(r, effort=factor * r.effort)))
    assert found.kind == kind
    share = float(found.evidence.split(" is ")[1].split(" ")[0])
    assert abs(share / factor - 1) < 0.2  # the description of this arm is right


def test_drive_gains(ur5: pid.Robot, runs: Runs) -> None:
    def change(r: pid.Recording) -> pid.Recording:
        return replace(r, effort=r.effort / 10, effort_kind="current", drive_gains=(1.0,) * 6)

    (found,) = pid.check_setup(ur5, each(runs, change))
    assert found.kind == "drive_gains"
    assert "too small" in found.statement
    without = each(runs, lambda r: replace(r, effort=r.effort / 10, effort_kind="current"))
    assert kinds(ur5, without) == []  # nothing is known of the size of currents without gains


def test_efforts_that_are_velocities(ur5: pid.Robot, runs: Runs) -> None:
    wrong = each(runs, lambda r: replace(r, effort=np.gradient(r.q, r.time, axis=0)))
    assert kinds(ur5, wrong) == [("effort_unlike", ())]


def test_a_load_is_no_mistake(ur5: pid.Robot, runs: Runs) -> None:
    """5 kg, the arm's rated payload, half a metre from joint 3."""
    model = ur5.pinocchio.copy()
    model.inertias[6] = model.inertias[6] + pin.Inertia(5.0, np.array([0.0, 0.0, 0.1]), np.zeros((3, 3)))
    bare, loaded = ur5.pinocchio.createData(), model.createData()

    def change(r: pid.Recording) -> pid.Recording:
        more = [
            pin.computeGeneralizedGravity(model, loaded, q) - pin.computeGeneralizedGravity(ur5.pinocchio, bare, q)
            for q in r.q
        ]
        return replace(r, effort=r.effort + np.array(more))

    assert kinds(ur5, each(runs, change)) == []


def test_gravity_taken_out_and_upside_down(ur5: pid.Robot, runs: Runs) -> None:
    data = ur5.pinocchio.createData()

    def gravity(r: pid.Recording) -> Array:
        return np.array([pin.computeGeneralizedGravity(ur5.pinocchio, data, q) for q in r.q])

    assert kinds(ur5, each(runs, lambda r: replace(r, effort=r.effort - gravity(r)))) == [("gravity_removed", ())]
    assert kinds(ur5, each(runs, lambda r: replace(r, effort=r.effort - 2 * gravity(r)))) == [("gravity_direction", ())]


@pytest.mark.parametrize("share", [1.6, 2.0])
def test_a_counterbalance_turns_no_gravity_over(ur5: pid.Robot, runs: Runs, share: float) -> None:
    """A spring that holds joint 2 up by more than its gravity: joint 3 shows that the arm stands as it is described."""

    data = ur5.pinocchio.createData()

    def held(r: pid.Recording) -> pid.Recording:
        gravity = [pin.computeGeneralizedGravity(ur5.pinocchio, data, q)[1] for q in r.q]
        return replace(r, effort=r.effort - share * np.outer(gravity, np.arange(6) == 1))

    assert kinds(ur5, each(runs, held)) == []


def rigid(robot: pid.Robot, r: pid.Recording) -> Array:
    """Torque of the description's links along the smoothed motion, by pinocchio."""
    from scipy.signal import savgol_filter

    step = float(np.median(np.diff(r.time)))
    q, v, a = (np.asarray(savgol_filter(r.q, 41, 5, deriv=k, delta=step, axis=0)) for k in range(3))
    data = robot.pinocchio.createData()
    return np.array([pin.rnea(robot.pinocchio, data, *row) for row in zip(q, v, a, strict=True)])


def test_a_model_s_torque_and_a_sensor_behind_the_gear(ur5: pid.Robot, runs: Runs) -> None:
    rng = np.random.default_rng(3)
    model = each(runs, lambda r: replace(r, effort=rigid(ur5, r)))
    assert kinds(ur5, model) == [("model_torque", ())]

    def sensed(r: pid.Recording) -> pid.Recording:
        torque = rigid(ur5, r)
        return replace(r, effort=torque + 0.01 * torque.std(axis=0) * rng.standard_normal(torque.shape))

    (found,) = pid.check_setup(ur5, each(runs, sensed))
    assert (found.kind, found.void, found.note) == ("link_side", False, True)
    mixed = each(runs, lambda r: replace(r, effort=np.column_stack([rigid(ur5, r)[:, :3], r.effort[:, 3:]])))
    assert kinds(ur5, mixed) == [("mixture", (1, 2, 3))]


@pytest.mark.parametrize("delay", [-0.06, 0.06])
def test_a_delay_is_measured(ur5: pid.Robot, runs: Runs, delay: float) -> None:
    def change(r: pid.Recording) -> pid.Recording:
        return replace(r, effort=np.column_stack([np.interp(r.time - delay, r.time, column) for column in r.effort.T]))

    (found,) = pid.check_setup(ur5, each(runs, change))
    assert found.kind == "effort_delay"
    assert ("later" if delay > 0 else "earlier") in found.statement
    low, high = (float(x) / 1e3 for x in found.evidence.removeprefix("interval ").removesuffix(" ms").split(" to "))
    assert low < delay < high


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        (lambda dq: -dq, ("velocity_sign", ALL)),
        (lambda dq: np.degrees(dq), ("velocity_degrees", ALL)),
        (lambda dq: np.radians(dq), ("position_degrees", ALL)),
        (lambda dq: 100 * dq, ("velocity_motor", ALL)),
        (lambda dq: 1.5 * dq, ("velocity_scale", ALL)),
        (lambda dq: dq[:, swapped(2, 5)], ("velocity_order", (2, 5))),
        (lambda dq: dq * [1, 1, -1, 1, 1, 1], ("velocity_sign", (3,))),
        (lambda dq: np.roll(dq, len(dq) // 3, axis=0), ("velocity_unlike", ALL)),
    ],
    ids=["sign", "degrees", "q in degrees", "motor", "scale", "swapped", "one sign", "unlike"],
)
def test_velocity_that_contradicts_position(
    runs: Runs, change: Callable[[Array], Array], kind: tuple[str, tuple[int, ...]]
) -> None:
    def derived(r: pid.Recording) -> Array:
        return np.gradient(r.q, r.time, axis=0)

    assert kinds(None, each(runs, lambda r: replace(r, dq=derived(r)))) == []
    assert kinds(None, each(runs, lambda r: replace(r, dq=change(derived(r))))) == [kind]


def test_q_and_dq_swapped_and_a_late_velocity(runs: Runs) -> None:
    one = runs[0]
    v = np.gradient(one.q, one.time, axis=0)
    assert kinds(None, [replace(one, q=v, dq=np.array(one.q))]) == [("position_velocity_swapped", ())]
    late = np.column_stack([np.interp(one.time - 0.04, one.time, column) for column in v.T])
    (found,) = pid.check_setup(None, [replace(one, dq=late)])
    assert found.kind == "velocity_late"
    assert abs(float(found.evidence.split("by ")[1].split(" ")[0]) - 40) < 3


def test_saturation_and_steps(runs: Runs) -> None:
    one = runs[0]
    most = 0.6 * np.abs(one.effort[:, 1]).max()
    clipped = np.array(one.effort)
    clipped[:, 1] = np.clip(clipped[:, 1], -most, most)
    assert kinds(None, [replace(one, effort=clipped)]) == [("saturation", (2,))]
    step = one.effort.std(axis=0) / 3
    assert kinds(None, [replace(one, effort=np.round(one.effort / step) * step)]) == [("quantisation", ALL)]
    held = np.repeat(one.effort[::4], 4, axis=0)[: len(one.effort)]  # logged faster than it is updated
    assert kinds(None, [replace(one, effort=held)]) == []


def test_shares_equal_those_of_all_subsets_of_columns(ur5: pid.Robot, runs: Runs) -> None:
    """The shares that a channel leaves, from products over blocks, against least squares on the rows with every subset of the columns."""
    rows = rows_of(ur5, runs)
    assert rows is not None
    moments = moments_of(rows)
    plus, minus = unexplained(moments)
    np.testing.assert_allclose(np.diag(plus), own_unexplained(moments), atol=1e-9)
    torque, columns = rows.centred(rows.torque), rows.columns
    for i, j in ((0, 0), (2, 1), (1, 1), (4, 4)):
        norms = np.linalg.norm(columns[j], axis=0)
        x = columns[j][:, norms > 1e-6] / norms[norms > 1e-6]
        for sign, found in ((1.0, plus), (-1.0, minus)):
            best = _best_of_all_subsets(x, sign * torque[:, i])
            assert abs(best / (torque[:, i] @ torque[:, i]) - found[i, j]) < 1e-6


def _best_of_all_subsets(x: Array, y: Array) -> float:
    """The smallest sum of squares that coefficients of zero or more leave, by trying which of them are zero."""
    best = float(y @ y)
    for count in range(1, x.shape[1] + 1):
        for chosen in itertools.combinations(range(x.shape[1]), count):
            part = x[:, chosen]
            theta = np.linalg.lstsq(part, y, rcond=None)[0]
            if (theta >= 0).all():
                best = min(best, float(np.sum((y - part @ theta) ** 2)))
    return best


def test_jackknife_of_a_mean_is_student_s_interval() -> None:
    from scipy.stats import t

    values = np.random.default_rng(5).normal(2.0, 1.0, 10)
    found = jackknife(np.array(values.mean()), np.array([np.delete(values, k).mean() for k in range(10)]))
    low, high = t.interval(LEVEL, 9, values.mean(), values.std(ddof=1) / np.sqrt(10))
    np.testing.assert_allclose([found.low, found.high], [low, high], rtol=1e-12)


def test_bad_input_is_one_line(ur5: pid.Robot, runs: Runs) -> None:
    three = replace(runs[0], q=runs[0].q[:, :3], dq=None, effort=runs[0].effort[:, :3])
    for robot, chosen in ((ur5, [three]), (None, [runs[0], three])):
        with pytest.raises(pid.InputError, match="3 joints, but") as error:
            pid.check_setup(robot, chosen)
        assert "\n" not in str(error.value)
    assert pid.check_setup(ur5, []) == ()
    assert pid.check_setup(ur5, runs[0]) == ()
    still = replace(runs[0], q=np.tile(runs[0].q[:1], (len(runs[0].q), 1)), dq=None)
    assert pid.check_setup(ur5, [still]) == ()


def test_real_recordings(data: Path) -> None:
    ur10e, ur5 = pid.load_robot(data / "ur10e/ur10e.urdf"), pid.load_robot("ur5")
    runs = pid.load_recordings(str(data / "ur10e/ur-20_02_06*.csv"), UR10E_COLUMNS, UR10E_GAINS)
    assert kinds(ur10e, runs) == []
    assert kinds(ur5, runs) == [("description", ())]
    assert kinds(ur10e, each(runs, lambda r: r.with_drive_gains([-g for g in UR10E_GAINS]))) == [("effort_sign", ALL)]
    assert kinds(ur10e, each(runs, lambda r: r.with_drive_gains([g / 10 for g in UR10E_GAINS]))) == [
        ("drive_gains", ())
    ]
    desired = pid.load_recordings(str(data / "ur10e/ur-20_02_06*.csv"), "time=0,q=1:7,dq=7:13,tau=25:31")
    assert kinds(ur10e, desired) == [("model_torque", ())]
    loads = pid.load_recordings(str(data / "ur10e/*load*.csv"), UR10E_COLUMNS, UR10E_GAINS)
    for one in (*loads, *pid.load_recordings(str(data / "ur5/*.csv.gz"), None, UR5_GAINS)):
        assert kinds(ur10e if "ur10e" in one.source else ur5, [one]) == []
