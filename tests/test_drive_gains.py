"""Drive gains from a load of known mass: found where torques decide them, refused where only products show."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.robots.inertia import pseudo_inertia
from physident.simulation.sensors import Sensors
from tests.conftest import UR10E_COLUMNS
from tests.loads import EFFECTS, SENSORS, arm, body, record

GAINS = np.array([14.0, 12.0, 10.0, 9.0, 11.0, 8.0])  # N m/A
LOAD = body(4.0, (0.05, 0.08, 0.1), (0.02, 0.03, 0.025))


def currents(model: pid.Model, seed: int, sensors: Sensors = SENSORS) -> pid.Recording:
    """A recording of motor currents, whose gains it does not tell."""
    one = record(model, seed, sensors)
    return replace(one, effort=one.effort / GAINS, effort_kind="current")


@pytest.fixture(scope="module")
def free(ur5: pid.Robot) -> list[pid.Recording]:
    return [currents(arm(ur5), seed) for seed in (1, 2)]


@pytest.fixture(scope="module")
def carried(ur5: pid.Robot) -> list[pid.Recording]:
    return [currents(arm(ur5, LOAD), seed) for seed in (3, 4)]


@pytest.fixture(scope="module")
def tls(ur5: pid.Robot, free: list[pid.Recording], carried: list[pid.Recording]) -> pid.DriveGains:
    return pid.identify_drive_gains(ur5, free, carried, LOAD[0], effects=EFFECTS)


@pytest.fixture(scope="module")
def clean(ur5: pid.Robot) -> tuple[list[pid.Recording], list[pid.Recording]]:
    return [currents(arm(ur5), 1, Sensors())], [currents(arm(ur5, LOAD), 3, Sensors())]


@pytest.mark.parametrize("method", ["tls", "ls", "physical"])
def test_without_noise_every_method_finds_the_gains(
    ur5: pid.Robot, clean: tuple[list[pid.Recording], list[pid.Recording]], method: str
) -> None:
    found = pid.identify_drive_gains(ur5, *clean, LOAD[0], method, EFFECTS)
    np.testing.assert_allclose(found.gains, GAINS, rtol=0.01)
    np.testing.assert_allclose(found.load[1:4] / found.load[0], LOAD[1:4] / LOAD[0], atol=2e-3)


def test_counts_of_a_drive_are_as_good_as_amperes(
    ur5: pid.Robot, clean: tuple[list[pid.Recording], list[pid.Recording]]
) -> None:
    """What one unit is worth is sought, so that no size of the numbers is absurd: ten thousand times the arm's limits."""
    free, carried = ([replace(r, effort=1e5 * r.effort) for r in group] for group in clean)
    found = pid.identify_drive_gains(ur5, free, carried, LOAD[0], effects=EFFECTS)
    np.testing.assert_allclose(1e5 * found.gains, GAINS, rtol=0.01)


def test_a_dead_channel_has_no_gain(ur5: pid.Robot, clean: tuple[list[pid.Recording], list[pid.Recording]]) -> None:
    (free,), carried = clean
    effort = np.array(free.effort)
    effort[:, 1] = 0.75
    with pytest.raises(pid.InputError, match=r"current of joint 2 is 0\.75 A in every row"):
        pid.identify_drive_gains(ur5, [replace(free, effort=effort)], carried, LOAD[0], effects=EFFECTS)


def test_with_noise_intervals_hold_the_truth(tls: pid.DriveGains) -> None:
    inside = (tls.intervals[:, 0] < GAINS) & (tls.intervals[:, 1] > GAINS)
    assert inside.sum() >= 5  # of six 95 % intervals
    np.testing.assert_allclose(tls.gains[1:4], GAINS[1:4], rtol=0.05)  # the joints that carry the load against gravity
    np.testing.assert_allclose(tls.load[1:4] / tls.load[0], LOAD[1:4] / LOAD[0], atol=0.01)


def test_loads_that_contradict_each_other_are_named(
    ur5: pid.Robot, free: list[pid.Recording], carried: list[pid.Recording], tls: pid.DriveGains
) -> None:
    """Two loads of one mass on opposite sides: gains of their mean are wrong by up to half, and no interval is printed."""
    opposite = currents(arm(ur5, body(4.0, (-0.05, -0.08, 0.1), (0.02, 0.03, 0.025))), 4)
    found = pid.identify_drive_gains(ur5, free, [carried[0], opposite], LOAD[0], effects=EFFECTS)
    assert tls.warnings == ()
    assert re.search(
        r"with load contradict each other: its centre of mass is at \(.*\) mm in .* seed 3 and at .* seed 4",
        found.warnings[0],
    )
    assert "on joint 6" in found.warnings[1]
    assert "verdict: doubtful: " in repr(found)
    assert "--drive-gains" not in repr(found)
    assert found.as_dict()["intervals_Nm_A"] == [None] * 6
    assert found.as_dict()["warnings"] == list(found.warnings)


def test_least_squares_is_pulled_down_by_noise(
    ur5: pid.Robot, free: list[pid.Recording], carried: list[pid.Recording]
) -> None:
    rng = np.random.default_rng(0)

    def louder(recordings: list[pid.Recording]) -> list[pid.Recording]:
        size = 6 * np.array(SENSORS.torque_noise) / GAINS
        return [replace(r, effort=r.effort + size * rng.normal(size=r.effort.shape)) for r in recordings]

    noisy = louder(free), louder(carried)
    plain, total = (pid.identify_drive_gains(ur5, *noisy, LOAD[0], m, EFFECTS) for m in ("ls", "tls"))
    assert np.median(plain.gains / GAINS) < 0.8
    assert abs(np.median(total.gains / GAINS) - 1) < 0.1
    assert "too small" in repr(plain)


def test_physical_keeps_every_part_a_body(
    ur5: pid.Robot, free: list[pid.Recording], carried: list[pid.Recording], tls: pid.DriveGains
) -> None:
    found = pid.identify_drive_gains(ur5, free, carried, LOAD[0], "physical", EFFECTS)
    assert np.linalg.eigvalsh(pseudo_inertia(found.load))[0] > 0
    assert (np.abs(np.log(found.gains / GAINS)) < 0.1).all()
    assert found.load[0] == LOAD[0]


def test_gains_scale_with_the_mass_and_against_the_current(
    ur5: pid.Robot, free: list[pid.Recording], carried: list[pid.Recording], tls: pid.DriveGains
) -> None:
    """A scale, not a number: twice the mass means twice the gains; currents in half amperes, half the gains."""
    twice = pid.identify_drive_gains(ur5, free, carried, 2 * LOAD[0], effects=EFFECTS)
    np.testing.assert_allclose(twice.gains, 2 * tls.gains, rtol=1e-5)
    units = np.array([2.0, 1.0, 0.5, 1.0, 1.0, 4.0])

    def in_other_units(recordings: list[pid.Recording]) -> list[pid.Recording]:
        return [replace(r, effort=r.effort * units) for r in recordings]

    other = pid.identify_drive_gains(ur5, in_other_units(free), in_other_units(carried), LOAD[0], effects=EFFECTS)
    np.testing.assert_allclose(other.gains * units, tls.gains, rtol=1e-5)


def test_gains_a_recording_holds_are_not_used(
    ur5: pid.Robot, free: list[pid.Recording], carried: list[pid.Recording], tls: pid.DriveGains
) -> None:
    told_free, told_carried = ([r.with_drive_gains([3.0] * 6) for r in group] for group in (free, carried))
    again = pid.identify_drive_gains(ur5, told_free, told_carried, LOAD[0], effects=EFFECTS)
    np.testing.assert_allclose(again.gains, tls.gains, rtol=1e-9)


TOWER = """<robot name="tower"><link name="base"/>
 <link name="column"><inertial><mass value="3"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
 <joint name="turn" type="revolute"><parent link="base"/><child link="column"/><axis xyz="0 0 1"/>
  <limit lower="-3" upper="3" velocity="3" effort="50"/></joint>
 {lift}
</robot>"""
LIFT = """<link name="table"><inertial><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
 <joint name="lift" type="prismatic"><parent link="column"/><child link="table"/><axis xyz="0 0 1"/>
  <limit lower="-1" upper="1" velocity="3" effort="50"/></joint>"""


def tower_currents(robot: pid.Robot, load: np.ndarray | None, seed: int) -> pid.Recording:
    model = pid.Model.nominal(robot, ["rigid_body", "viscous_friction"])
    theta = np.array(model.theta)
    theta[-robot.n :] = 2.0
    if load is not None:
        theta[10 * (robot.n - 1) : 10 * robot.n] += load
    time, q, v, a = pid.random_trajectory(robot, seed=seed, duration=20.0).sample(100.0)
    torque = replace(model, theta=theta).torque(pid.Signals.of_states(q, v, a))
    noise = 0.01 * np.random.default_rng(seed).normal(size=torque.shape)
    return pid.Recording(time, q, torque / 5.0 + noise, "current", dq=v)


def test_a_joint_the_known_mass_does_not_load_is_refused_and_named() -> None:
    """A lift turned about its own axis: the load's weight is on the lift alone; turning shows K and inertia as a product."""
    robot = pid.Robot("tower", TOWER.format(lift=LIFT))
    groups = [tower_currents(robot, None, 1)], [tower_currents(robot, LOAD, 2)]
    found = pid.identify_drive_gains(robot, *groups, LOAD[0], effects=["rigid_body", "viscous_friction"])
    assert found.found.tolist() == [False, True]
    assert found.gains[1] == pytest.approx(5.0, rel=0.02)
    assert "    1  cannot be separated" in repr(found)
    assert found.as_dict()["gains_Nm_A"][0] is None
    json.dumps(found.as_dict(), allow_nan=False)


def test_a_load_that_no_joint_feels_is_refused() -> None:
    robot = pid.Robot("column", TOWER.format(lift=""))
    groups = [tower_currents(robot, None, 1)], [tower_currents(robot, LOAD, 2)]
    with pytest.raises(pid.InputError, match="cannot be separated"):
        pid.identify_drive_gains(robot, *groups, LOAD[0], effects=["rigid_body", "viscous_friction"])


def test_a_load_that_is_not_there_is_not_turned_into_gains(ur5: pid.Robot, free: list[pid.Recording]) -> None:
    """Recordings called loaded that are not: a mass without weight would need gains without bound."""
    try:
        found = pid.identify_drive_gains(ur5, free[:1], free[1:], 4.0, effects=EFFECTS)
    except (pid.NotSolvedError, pid.InputError):
        return
    assert "vague" in repr(found)
    assert np.median(found.intervals[:, 1] / found.intervals[:, 0]) > 2


def test_what_cannot_be_used_is_refused(
    ur5: pid.Robot, free: list[pid.Recording], carried: list[pid.Recording]
) -> None:
    with pytest.raises(pid.InputError, match="cannot be separated"):
        pid.identify_drive_gains(ur5, free, [], 4.0)
    with pytest.raises(pid.InputError, match="positive"):
        pid.identify_drive_gains(ur5, free, carried, 0.0)
    with pytest.raises(pid.InputError, match="contains torques"):
        pid.identify_drive_gains(ur5, free, [replace(carried[0], effort_kind="torque")], 4.0)
    with pytest.raises(pid.InputError, match="both"):
        pid.identify_drive_gains(ur5, free, free, 4.0)
    with pytest.raises(pid.InputError, match="load_dependent_friction"):
        pid.identify_drive_gains(ur5, free, carried, 4.0, effects=[*EFFECTS, "load_dependent_friction"])
    with pytest.raises(pid.InputError, match="unknown"):
        pid.identify_drive_gains(ur5, free, carried, 4.0, method="gls")


def test_on_a_real_arm_the_command_line_finds_gains(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    """On the joints that carry the load the literature's gains fit within the intervals; the owner's own do not."""
    folder, out = data / "ur10e", tmp_path / "gains.json"
    options = ["--robot", str(folder / "ur10e.urdf"), "--columns", UR10E_COLUMNS, "--load-mass", "2.6"]
    recordings = ["--unloaded", str(folder / "ur-20_02_1*.csv"), "--loaded", str(folder / "ur-20_01_13-load_2600.csv")]
    assert run(["drive-gains", *options, *recordings, "--json", str(out)]) == 0
    assert "of 6 gains known within" in capsys.readouterr().out
    low, high = np.array(json.loads(out.read_text())["intervals_Nm_A"])[1:4].T
    literature, owner = np.array([13.26, 11.13, 10.62]), np.array([10.70, 8.46, 9.00])
    assert ((low < literature) & (literature < high)).all()
    assert (owner < low).all()
