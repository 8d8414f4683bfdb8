"""The motion of a recording, planned again: smooth, from standstill to standstill, within the limits, and written like any other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.errors import InputError
from physident.excitation.limits.robot_limits import with_limits
from physident.excitation.motion.recorded import LEAD, RecordedMotion
from physident.excitation.motion.trajectory import load_trajectory
from physident.recordings.preparation import prepare
from physident.recordings.signals import Signals
from tests.plant import Arm, Sensors, multisine, record


@pytest.fixture(scope="module")
def signals(tmp_path_factory: pytest.TempPathFactory) -> Signals:
    path = tmp_path_factory.mktemp("recorded") / "run.csv"
    record(Arm(), multisine(5), Sensors(), 5, step=2e-3).write_csv(path)
    return prepare(pid.load_recording(path), pid.Filter())


@pytest.fixture(scope="module")
def motion(signals: Signals, ur5: pid.Robot) -> RecordedMotion:
    made = RecordedMotion.of_signals(signals, 100.0, ur5)
    assert made is not None
    return made


def test_it_follows_the_recording(signals: Signals, motion: RecordedMotion) -> None:
    moving = signals.moving
    assert moving is not None
    late = min(float(signals.time[-1]), moving[1])
    time = np.linspace(moving[0] + 1.0, late - 1.0, 400)
    measured = np.array([np.interp(time, signals.time, column) for column in signals.q.T]).T
    # the clocks differ by what was cut off before the arm moved, and by a lead where it was cut at speed
    lags = np.linspace(0, 2.5, 2501)
    errors = [np.abs(motion.states(time - moving[0] + lag).q - measured).max() for lag in lags]
    assert min(errors) < 2e-3  # rad, of motions of a radian


def test_it_starts_and_ends_at_standstill_and_its_derivatives_fit(motion: RecordedMotion) -> None:
    ends = motion.states(np.array([-1.0, 0.0, motion.duration, motion.duration + 1.0]))
    np.testing.assert_allclose(ends.v, 0.0, atol=1e-9)
    np.testing.assert_allclose(ends.q[0], ends.q[1])
    step = 1e-4
    time = np.linspace(0.5, motion.duration - 0.5, 300)
    before, now, after = (motion.states(time + k * step) for k in (-1, 0, 1))
    np.testing.assert_allclose((after.q - before.q) / (2 * step), now.v, atol=1e-4)
    np.testing.assert_allclose((after.v - before.v) / (2 * step), now.a, atol=0.1)


def test_its_extent_bounds_every_instant_and_is_reached(motion: RecordedMotion) -> None:
    extent, states = motion.extent(), motion.states(np.linspace(0, motion.duration, 200_001))
    for bound, values in ((extent.upper, states.q), (-extent.lower, -states.q), (extent.speed, np.abs(states.v))):
        assert (values.max(axis=0) <= bound + 1e-12).all()
        np.testing.assert_allclose(values.max(axis=0), bound, atol=1e-6)
    assert (np.abs(states.a).max(axis=0) <= extent.acceleration + 1e-9).all()


def test_a_part_is_started_and_stopped_gently(signals: Signals, motion: RecordedMotion, ur5: pid.Robot) -> None:
    part = RecordedMotion.of_signals(signals, 8.0, ur5)
    assert part is not None
    assert part.duration <= 8.0
    last = part.states(np.array([part.duration]))
    np.testing.assert_allclose(last.v, 0.0, atol=1e-9)
    assert (part.extent().acceleration < motion.extent().acceleration + motion.extent().speed * np.pi / LEAD).all()


def test_it_starts_and_stops_inside_of_the_range_of_every_joint(signals: Signals, ur5: pid.Robot) -> None:
    room = 0.01  # rad beyond what was recorded
    lower, upper = (",".join(map(str, at)) for at in (signals.q.min(axis=0) - room, signals.q.max(axis=0) + room))
    tight = with_limits(ur5, f"lower={lower} upper={upper}")
    outward = np.abs(signals.v).max(axis=1) * LEAD / 2 > 0.3
    leaving = outward & ((signals.q - LEAD / 2 * signals.v > tight.upper).any(axis=1))
    begin = int(np.flatnonzero(leaving)[0])  # from here on no second is left to have come from standstill
    cut = signals.part(slice(begin, begin + 6000))
    free, inside = (RecordedMotion.of_signals(cut, 100.0, robot) for robot in (ur5, tight))
    assert free is not None
    assert inside is not None
    assert (free.extent().upper > tight.upper + room).any()
    assert (inside.extent().upper <= tight.upper + room).all()
    assert (inside.extent().lower >= tight.lower - room).all()
    assert free.duration - 1.5 < inside.duration < free.duration  # no more is given up than it takes


def test_what_stands_still_has_no_motion(signals: Signals, ur5: pid.Robot) -> None:
    still = replace(signals, q=np.zeros_like(signals.q), v=np.zeros_like(signals.v), a=np.zeros_like(signals.a))
    assert RecordedMotion.of_signals(still, 10.0, ur5) is None


def test_it_is_written_and_read_like_any_other(motion: RecordedMotion, tmp_path: Path) -> None:
    motion.save(tmp_path / "again.json")
    read = load_trajectory(tmp_path / "again.json")
    time = np.linspace(0, motion.duration, 50)
    np.testing.assert_allclose(read.states(time).q, motion.states(time).q, atol=1e-12)
    with pytest.raises(InputError, match="3 points at 10"):
        RecordedMotion(np.zeros((3, 2)), 10.0)
    with pytest.raises(InputError, match="positive rate"):
        RecordedMotion(np.zeros((9, 2)), 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(("minutes", "seconds"), [(1.0, 20.0), (2.0, 60.0), (2.0, 45.0)])
def test_a_long_motion_that_is_repeated_keeps_the_session_s_time(
    ur5: pid.Robot, tmp_path: Path, minutes: float, seconds: float
) -> None:
    """What warms the arm and ends the session is as long as there is room for, not another minute."""
    for k in range(2):
        run = record(Arm(), multisine(5 + k, duration=seconds, speed=0.6), Sensors(), 5, step=4e-3)
        run.write_csv(tmp_path / f"before{k}.csv")
    paths = [tmp_path / f"before{k}.csv" for k in range(2)]
    session = pid.design_session(
        replace(ur5, acceleration_limit=None), repeat=paths, minutes=minutes, limits="joint", pool=4
    )
    assert isinstance(session.legs[session.legs[0].warm_up].trajectory, RecordedMotion)
    assert session.duration <= 60 * minutes + 1e-6
    assert sum(leg.role == "fit" for leg in session.legs) >= 2


def test_a_session_begins_with_what_is_repeated(ur5: pid.Robot, tmp_path: Path) -> None:
    record(Arm(), multisine(5, speed=0.6), Sensors(), 5, step=2e-3).write_csv(tmp_path / "before.csv")
    settings = {"minutes": 1.0, "limits": "joint", "pool": 4}
    arm = replace(ur5, acceleration_limit=None)
    session = pid.design_session(arm, repeat=tmp_path / "before.csv", **settings)
    first, *others = session.legs
    assert isinstance(first.trajectory, RecordedMotion)
    assert first.name == "01_again"
    assert "before.csv" in first.purpose
    assert others[-1].holdout
    assert session.duration <= 60.0 + 1e-6
    slow = with_limits(arm, "speed=0.1")
    refused = pid.design_session(slow, repeat=tmp_path / "before.csv", **settings)
    assert not any(isinstance(leg.trajectory, RecordedMotion) for leg in refused.legs)
    assert refused.outlook is not None
    assert any("before.csv is not repeated: joint" in note for note in refused.outlook.notes)
    with pytest.raises(InputError, match="repeat was given without minutes"):
        pid.design_session(ur5, repeat=tmp_path / "before.csv")
