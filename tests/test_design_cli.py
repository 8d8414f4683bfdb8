"""physident design: files that hold what is printed, options that are refused in one line."""

from __future__ import annotations

import json

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from tests.bad_input.test_verbs import ONE
from tests.robots import TREE


def test_design_writes_what_it_prints(tmp_path, capsys):
    arm = tmp_path / "tree.urdf"
    arm.write_text(TREE)
    files = {name: tmp_path / name for name in ("plan.json", "plan.csv", "summary.json", "plan.png")}
    command = [
        "design",
        "--robot",
        str(arm),
        "--limits",
        "joint",
        "--harmonics",
        "3",
        "--base-frequency",
        "0.2",
        "--periods",
        "2",
    ]
    outputs = ["--out", "plan.json", "--csv", "plan.csv", "--json", "summary.json", "--plot", "plan.png"]
    paths = [str(files[word]) if word in files else word for word in outputs]
    assert run([*command, *paths, "--rate", "50"]) == 0
    text = capsys.readouterr().out
    summary = json.loads(files["summary.json"].read_text())
    motion = pid.load_trajectory(files["plan.json"])
    assert motion.duration == pytest.approx(10.0)
    assert f"condition number {summary['condition']:.2f}" in text
    assert all(one["margin"] > 0 for one in summary["margins"])
    assert "torque, tool, table and links were not checked" in text.partition("verdict:")[2]
    assert "every limit" not in text
    assert "manipulability" in text
    table = np.loadtxt(files["plan.csv"], delimiter=",", skiprows=1)
    assert table.shape == (501, 1 + 3 * 4)
    np.testing.assert_allclose(table, np.column_stack(motion.sample(50.0)), atol=1e-9)
    assert files["plan.png"].stat().st_size > 10_000


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ([], "which arm?"),
        (["--robot", "ur5", "--model", "m.json"], "both given"),
        (["--robot", "ur5", "--limits", "some"], "limits is 'some'"),
        (["--robot", "ur5", "--criterion", "best"], "criterion is 'best'"),
        (["--robot", "ur5", "--joint", "2"], "--discriminate"),
        (["--robot", "ur5", "--criterion", "d_optimal", "--discriminate", "payload", "time_delay"], "both given"),
        (["--robot", "ur5", "--discriminate", "payload", "rust", "--noise", "1"], "'rust' cannot be separated"),
        (["--robot", "ur5", "--discriminate", "payload", "torque_constant"], "how much torque noise"),
        (["--robot", "ur5", "--periods", "0"], "periods is 0"),
        (["--robot", "ur5", "--rate", "-1", "--csv", "x.csv"], "rate"),
    ],
)
def test_bad_options_are_one_line_and_no_file(options, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["design", *options, "--out", "plan.json"]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_an_arm_of_one_joint_has_a_design_and_no_coupled_rival(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "one.urdf").write_text(f"{ONE}</robot>\n")
    command = ["design", "--robot", "one.urdf", "--limits", "joint", "--harmonics", "2", "--out", "plan.json"]
    rivals = ["--discriminate", "viscous_friction", "coupled_friction", "--noise", "1"]
    assert run([*command, *rivals]) == 2
    error = capsys.readouterr().err
    assert "has no joint for viscous_friction beside coupled_friction" in error
    assert error.count("\n") == 1
    assert not (tmp_path / "plan.json").exists()
    assert run(command) == 0
    motion = pid.load_trajectory(tmp_path / "plan.json")
    poses = motion.sample(20.0)[1]
    # one joint's tool turns at its rate and goes nowhere else: the Jacobian is one column, as long at every pose
    found = pid.measure_manipulability(pid.load_robot("one.urdf"), poses)
    np.testing.assert_allclose(found.measure, found.measure[0])
    np.testing.assert_allclose(found.ratio, 1.0)
