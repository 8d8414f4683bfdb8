"""A fleet's recordings on a local cluster: only new files are worked on, broken ones are rows, killed workers cost time."""

from __future__ import annotations

import re
from datetime import date
from pathlib import Path

import numpy as np
import pinocchio as pin
import pyarrow.dataset as ds
import pytest

import physident as pid
from physident.cli import run
from physident.errors import InputError
from physident.fleet.changes import changes_in
from physident.fleet.dataset import read_rows
from physident.fleet.friction_laws import identify_with_friction_laws
from physident.fleet.naming import arm_and_day, pattern_of
from physident.fleet.run import run_fleet
from physident.fleet.work import Reading, make_baseline
from physident.robots.robot import Robot

pytest.importorskip("distributed", reason="needs the extra fleet")
URDF = """<robot name="two"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.2 0 0.02"/><mass value="4"/>
  <inertia ixx="0.05" iyy="0.06" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="lower"><inertial><origin xyz="0.15 0.01 0"/><mass value="2"/>
  <inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
  <limit lower="-3" upper="3" effort="200" velocity="5"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
  <limit lower="-3" upper="3" effort="200" velocity="5"/></joint></robot>"""
RATE, DURATION = 100.0, 15.0
DRY, VISCOUS = np.array([6.0, 3.0]), np.array([5.0, 2.0])


def write_run(
    path: Path, seed: int, friction: float = 1.0, constant: float = 1.0, payload: float = 0.0, lift: float = 0.0
) -> None:
    """A recording by pinocchio, with the friction of joint 1 and the torque constant of joint 2 scaled, a payload [kg], and ``lift`` [N m]
    more friction near standstill."""
    rng, time = np.random.default_rng(seed), np.arange(0, DURATION, 1 / RATE)
    tones = 2 * np.pi * np.array([0.13, 0.31, 0.47])[:, None]
    size, phase = rng.uniform(0.2, 0.5, (3, 2)), rng.uniform(0, 2 * np.pi, (3, 2))
    angle = tones * time[:, None, None] + phase
    q, v = (size * np.sin(angle)).sum(axis=1), (size * tones * np.cos(angle)).sum(axis=1)
    a = -(size * tones**2 * np.sin(angle)).sum(axis=1)
    model = pin.buildModelFromXML(URDF)
    model.inertias[2] += pin.Inertia(payload, np.array([0.3, 0.0, 0.0]), 1e-3 * payload * np.eye(3))
    data = model.createData()
    torque = np.array([pin.rnea(model, data, *state).copy() for state in zip(q, v, a, strict=True)])
    torque += (
        np.array([friction, 1.0]) * ((DRY + lift * np.exp(-((v / 0.1) ** 2))) * np.tanh(v / 0.003) + VISCOUS * v)
        + np.array([1.0, 0.4]) * a
    )
    torque = torque / np.array([1.0, constant]) + rng.normal(0, 0.1, q.shape)
    table = np.column_stack([time, q, v + rng.normal(0, 1e-3, v.shape), torque])
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(path, table, "%.12g", ",", header="time,q_1,q_2,dq_1,dq_2,tau_1,tau_2", comments="")


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path = tmp_path_factory.mktemp("robot") / "two.urdf"
    path.write_text(URDF, encoding="utf-8")
    return pid.load_robot(path)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two arms, three days each, and a broken file."""
    folder = tmp_path_factory.mktemp("runs")
    for arm in (1, 2):
        for day in (1, 2, 3):
            write_run(folder / f"arm{arm}" / f"2026-03-0{day}.csv", 10 * arm + day)
    (folder / "arm2" / "2026-03-04.csv").write_text("time,q_1\nnothing\n", encoding="utf-8")
    return folder


@pytest.mark.parametrize(
    ("change", "name", "size"),
    [
        ({"friction": 1.1}, "friction_1", 0.1),
        ({"constant": 0.95}, "torque_constant_2", 1 / 0.95 - 1),
        ({"payload": 0.5}, "payload_mass", 0.5),
    ],
)
def test_a_known_change_is_measured(tmp_path: Path, robot: Robot, change: dict, name: str, size: float) -> None:
    for seed in (1, 2):
        write_run(tmp_path / f"{seed}.csv", seed)
    write_run(tmp_path / "new.csv", 3, **change)
    baseline = pid.identify(robot, [tmp_path / "1.csv", tmp_path / "2.csv"])
    (found,) = [
        one for one in changes_in(baseline, pid.load_recordings(tmp_path / "new.csv")[0]) if one.parameter == name
    ]
    assert found.change == pytest.approx(size, abs=max(0.08 * size, 3 * found.std))
    assert found.std < 0.2 * size
    assert found.low < found.value < found.high


@pytest.mark.slow
def test_only_new_files_are_worked_on_and_a_broken_one_is_a_row(tmp_path: Path, robot: Robot, runs: Path) -> None:
    out, every = tmp_path / "fleet", [str(runs / "*" / "*.csv")]
    part = [str(runs / "arm1" / "2026-03-01.csv"), str(runs / "arm1" / "2026-03-02.csv")]
    first = run_fleet(robot, part, "{robot}/{date}", out, workers=1, baseline=2)
    assert (first.new, first.known, first.broken, first.arms) == (2, 0, 0, 1)
    before = {path.name: path.stat().st_mtime_ns for path in (out / "rows").iterdir()}
    second = run_fleet(robot, every, "{robot}/{date}", out, workers=1, baseline=2)
    assert (second.new, second.known, second.broken, second.arms) == (5, 2, 1, 2)
    for name, changed in before.items():
        assert (out / "rows" / name).stat().st_mtime_ns == changed
    rows = read_rows(out)
    (bad,) = [row for row in rows if row["error"] is not None]
    assert (bad["arm"], bad["day"], bad["parameter"]) == ("arm2", date(2026, 3, 4), None)
    assert "2026-03-04.csv" in bad["error"]
    good = [row for row in rows if row["parameter"] == "coulomb_friction_1"]
    assert [(row["arm"], row["day"].day) for row in good] == [
        (arm, day) for arm in ("arm1", "arm2") for day in (1, 2, 3)
    ]
    assert all(row["low"] < row["value"] < row["high"] for row in good)
    frame = ds.dataset(out / "rows").to_table().to_pandas()  # as pandas and DuckDB read it
    assert {"arm", "day", "parameter", "value", "low", "high", "finding", "error"} <= set(frame.columns)
    with pytest.raises(InputError, match="another baseline"):
        run_fleet(robot, every, "{robot}/{date}", out, workers=1, baseline=3)


@pytest.mark.slow
@pytest.mark.parametrize(("lift", "law"), [(0.0, False), (4.0, True)])
def test_a_baseline_has_the_laws_of_friction_that_its_recordings_show(
    tmp_path: Path, robot: Robot, lift: float, law: bool
) -> None:
    for seed in range(1, 9):
        write_run(tmp_path / f"{seed}.csv", seed, lift=lift)
    write_run(tmp_path / "unseen.csv", 9, lift=lift)
    runs = pid.load_recordings(str(tmp_path / "[1-8].csv"))
    found, default = identify_with_friction_laws(robot, runs), pid.identify(robot, runs)
    assert ("stribeck_friction" in [effect.name for effect in found.model.effects]) is law
    errors = [pid.validate(one, tmp_path / "unseen.csv").rms for one in (found, default)]
    assert (errors[0] <= (0.7 if law else 1.05) * errors[1]).all()


def test_friction_is_scaled_with_all_its_laws(tmp_path: Path, robot: Robot) -> None:
    for seed in range(1, 9):
        write_run(tmp_path / f"{seed}.csv", seed, lift=4.0)
    write_run(tmp_path / "new.csv", 9, lift=4.0, friction=1.2)
    baseline = identify_with_friction_laws(robot, pid.load_recordings(str(tmp_path / "[1-8].csv")))
    changes = {one.parameter: one for one in changes_in(baseline, pid.load_recording(tmp_path / "new.csv"))}
    assert changes["friction_1"].change == pytest.approx(0.2, abs=0.01)
    assert abs(changes["friction_2"].change) < 0.02
    assert not any("stribeck" in name for name in changes)


def test_a_baseline_leaves_out_files_that_cannot_be_used(tmp_path: Path, robot: Robot, runs: Path) -> None:
    good, broken = str(runs / "arm1" / "2026-03-01.csv"), str(runs / "arm2" / "2026-03-04.csv")
    still = tmp_path / "still.csv"
    rows = np.loadtxt(good, delimiter=",", skiprows=1)
    rows[:, 1:5] = [0.3, -0.2, 0.0, 0.0]
    np.savetxt(still, rows, "%.12g", ",", header="time,q_1,q_2,dq_1,dq_2,tau_1,tau_2", comments="")
    found = make_baseline(robot, [broken, str(still), good], 1, Reading())
    assert isinstance(found, pid.Estimate)
    assert [Path(source.path).name for source in found.sources] == ["2026-03-01.csv"]
    reason = make_baseline(robot, [broken, str(still)], 1, Reading())
    assert isinstance(reason, str)
    assert "still.csv" in reason


@pytest.mark.parametrize(
    ("by", "path", "arm", "day"),
    [
        ("{robot}/{date}", "logs/arm7/2026-03-01.csv.gz", "arm7", date(2026, 3, 1)),
        ("{robot}/{date}/run*", "logs/arm7/20260301/run_3.parquet", "arm7", date(2026, 3, 1)),
        ("{robot}_{date}", "logs/cell_2_arm_7_2026-03-01.mcap", "cell_2_arm_7", date(2026, 3, 1)),
        ("{date}/x{robot}", "2026-03-01/x9.npz", "9", date(2026, 3, 1)),
    ],
)
def test_arm_and_day_come_from_the_end_of_a_path(by: str, path: str, arm: str, day: date) -> None:
    assert arm_and_day(path, pattern_of(by)) == (arm, day)


@pytest.mark.parametrize("by", ["{robot}", "{date}", "{robot}/{robot}/{date}", "{arm}/{date}", ""])
def test_a_pattern_names_robot_and_date_once(by: str) -> None:
    with pytest.raises(InputError, match=re.escape("{robot}")):
        pattern_of(by)


@pytest.mark.parametrize("path", ["2026-03-01.csv", "arm/march.csv", "arm/2026-13-01.csv"])
def test_a_path_that_does_not_fit_is_refused(path: str) -> None:
    with pytest.raises(InputError, match="expected"):
        arm_and_day(path, pattern_of("{robot}/{date}"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--by", "{robot}/{date}", "--scheduler", "tcp://127.0.0.1:1"], "does not answer"),
        (["--by", "{robot}"], "--by is"),
        (["--by", "{robot}/{date}", "--baseline", "0"], "baseline is 0"),
    ],
)
def test_bad_input_is_one_line(
    tmp_path: Path, runs: Path, words: list[str], said: str, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "two.urdf").write_text(URDF, encoding="utf-8")
    file = str(runs / "arm1" / "2026-03-01.csv")
    command = ["fleet", file, "--robot", str(tmp_path / "two.urdf"), "--out", str(tmp_path / "out"), *words]
    assert run(command) == 2
    err = capfd.readouterr().err.strip()
    assert said in err
    assert err.count("\n") == 0
