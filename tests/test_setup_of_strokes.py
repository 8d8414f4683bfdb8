"""Strokes at a constant speed, as they are recorded to measure friction, and recordings with gaps are not taken for wrong set-ups."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.setup_checks.channel import relative_noise

BOOM = """<robot name="boom"><link name="mast"/>
  <link name="boom"><inertial><mass value="3.1"/><origin xyz="0.35 0 0"/>
    <inertia ixx="0.01" iyy="0.12" izz="0.12" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="luff" type="revolute"><parent link="mast"/><child link="boom"/><axis xyz="0 -1 0"/>
    <limit lower="-1.5" upper="1.5" effort="60" velocity="2"/></joint></robot>"""
BEAM = """<robot name="beam"><link name="post"/>
  <link name="beam"><inertial><mass value="9"/><origin xyz="0.3 0 0"/>
    <inertia ixx="0.1" iyy="0.6" izz="0.6" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="wrist"><inertial><mass value="0.4"/><origin xyz="0.01 0 0"/>
    <inertia ixx="0.003" iyy="0.003" izz="0.003" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="swing" type="revolute"><parent link="post"/><child link="beam"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="80" velocity="2"/></joint>
  <joint name="turn" type="revolute"><parent link="beam"/><child link="wrist"/><origin xyz="0.6 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="5" velocity="4"/></joint></robot>"""
SPEED, FAR, RUBS = 0.26, 0.9, 2.4  # rad/s, rad, N m


@pytest.fixture(scope="module")
def boom(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    path = tmp_path_factory.mktemp("boom") / "boom.urdf"
    path.write_text(BOOM)
    return pid.load_robot(path)


def strokes(times: int, gap: float = 0.0, speed_of: float = 1.0) -> pid.Recording:
    """A boom that luffs up and down at a constant speed; rows within ``gap`` [s] of a reversal are lost."""
    rng, lasts = np.random.default_rng(7), 2 * FAR / SPEED
    time = np.arange(0.02, times * lasts - 0.02, 0.004)
    stroke, at = np.divmod(time, lasts)
    way = 1 - 2 * (stroke % 2)
    q, v = way * (SPEED * at - FAR), way * SPEED
    torque = 3.1 * 9.81 * 0.35 * np.cos(q) + RUBS * way + 0.8 * v
    kept = (at > gap) & (at < lasts - gap) if gap else np.ones(len(time), dtype=bool)
    noise = rng.standard_normal((3, len(time))) * np.array([[3e-5], [2e-3], [0.05]])
    q, dq, effort = ((x + e)[kept, None] for x, e in zip((q, speed_of * v, torque), noise, strict=True))
    return pid.Recording.from_arrays(time[kept], q, dq=dq, effort=effort, source=f"{times} strokes")


def kinds(robot: pid.Robot, run: pid.Recording) -> list[str]:
    return [found.kind for found in pid.check_setup(robot, [run])]


@pytest.mark.parametrize(("times", "gap"), [(1, 0.0), (6, 0.4)])
def test_a_speed_that_is_held_follows_its_position(boom: pid.Robot, times: int, gap: float) -> None:
    assert not any(kind.startswith("velocity") for kind in kinds(boom, strokes(times, gap)))


@pytest.mark.parametrize(("speed_of", "kind"), [(-1.0, "velocity_sign"), (180 / np.pi, "velocity_degrees")])
def test_a_speed_that_is_held_in_another_unit_is_still_seen(boom: pid.Robot, speed_of: float, kind: str) -> None:
    assert kind in kinds(boom, strokes(1, speed_of=speed_of))


def test_friction_that_parts_of_one_direction_hide_is_not_called_absent(boom: pid.Robot) -> None:
    assert "link_side" not in kinds(boom, strokes(6, 0.4))


def test_friction_that_turns_the_other_way_only_in_another_recording_is_not_called_absent(boom: pid.Robot) -> None:
    """A zero of each recording could be all of it."""
    up, rng = strokes(1), np.random.default_rng(3)
    rubs = RUBS * np.ones((len(up.time), 1)) + 0.8 * SPEED
    effort = up.effort - 2 * rubs + 0.02 * rng.standard_normal(up.effort.shape)
    down = pid.Recording.from_arrays(up.time, up.q[::-1], dq=-np.array(up.dq)[::-1], effort=effort[::-1], source="down")
    assert "link_side" not in [found.kind for found in pid.check_setup(boom, [up, down])]


def test_an_effort_in_coarse_steps_is_no_exact_one() -> None:
    """A slow ramp that a drive reports in steps, one a sample; and a model's torque in double precision, which has no steps."""
    time = np.arange(0.0, 20.0, 0.02)
    ramp, smooth = 4.0 * np.abs((time / 8.0) % 2 - 1), 4.0 * np.sin(0.7 * time)
    step = 0.01
    stepped, exact = (
        pid.Recording.from_arrays(time, np.sin(time)[:, None], effort=one[:, None], source="ramp")
        for one in (step * np.round(ramp / step), smooth)
    )
    assert relative_noise([stepped])[0] == pytest.approx(step / np.sqrt(12) / ramp.std(), rel=0.1)
    assert relative_noise([exact])[0] < 1e-4


def test_a_joint_that_is_held_shows_no_inertia(tmp_path: Path) -> None:
    """A wrist swings about the axis of gravity; the beam that holds it has the inertia of the arm, and shakes by an encoder step or two."""
    (tmp_path / "beam.urdf").write_text(BEAM)
    rng, time = np.random.default_rng(5), np.arange(0.0, 20.0, 0.008)
    q = np.column_stack([np.full(len(time), 0.4), 1.1 * np.sin(1.3 * time)])
    v, a = 1.43 * np.cos(1.3 * time), -1.859 * np.sin(1.3 * time)
    drive = (0.02 + 0.003) * a + 0.15 * np.sign(v) + 0.2 * v
    effort = np.column_stack([0.8 * np.sin(0.9 * time) * (np.abs(v) < 1), drive]) + 0.03 * rng.standard_normal(q.shape)
    shaken = q + 3e-5 * rng.standard_normal(q.shape)
    run = pid.Recording.from_arrays(time, shaken, effort=effort, source="wrist")
    found = pid.check_setup(pid.load_robot(tmp_path / "beam.urdf"), [run])
    assert not [one for one in found if one.void], found
