"""Command lines that ask for what there is not."""

from __future__ import annotations

from pathlib import Path

import pytest

from physident.cli import run
from tests.bad_input.one_line_error import assert_one_line, command, fails

IDENTIFY = ["identify", "good.csv", "--robot", "ur5"]
TO = [*IDENTIFY, "--out", "out.json"]
VALIDATE = ["validate", "other.csv", "--model", "model.json"]
COMPARE = ["compare", "--model", "model.json", "--model", "model.json", "--on", "other.csv"]
OPTIONS: dict[str, tuple[list[str], str]] = {
    "unknown verb": (["improve"], "improve"),
    "unknown option": ([*TO, "--magic"], "--magic"),
    "option without value": ([*IDENTIFY, "--out"], "--out"),
    "no recordings": (["inspect"], "REC"),
    "recording not found": (["inspect", "nowhere.csv"], "not found"),
    "pattern without match": (["inspect", "nothing*.csv"], "not found"),
    "empty recording name": (["inspect", ""], "''"),
    "endless recording name": (["inspect", "x" * 5000 + ".csv"], "not found|too long"),
    "zero byte in a name": (["inspect", "a\0b.csv"], "not found|byte"),
    "no robot": (["identify", "good.csv", "--out", "out.json"], "no robot given"),
    "empty robot": (["identify", "good.csv", "--out", "out.json", "--robot", ""], "robot ''|no robot"),
    "robot with a zero byte": (["base-parameters", "--robot", "a\0b"], "not found"),
    "endless robot name": (["base-parameters", "--robot", "x" * 5000], "not found|too long"),
    "no out": (IDENTIFY, "--out"),
    "unknown effect": ([*TO, "--effects", "magic"], "'magic' is unknown"),
    "duplicated effects": ([*TO, "--effects", "rigid_body,rigid_body"], "twice"),
    "no effects": ([*TO, "--effects", ","], "no effects"),
    "empty effects": ([*TO, "--effects", ""], "no effects"),
    "effects without robot": (["inspect", "good.csv", "--effects", "rigid_body"], "needs a robot"),
    "base-parameters unknown effect": (["base-parameters", "--robot", "ur5", "--effects", "x"], "'x' is unknown"),
    "unknown method": ([*TO, "--method", "magic"], "'magic' is unknown"),
    "negative cutoff": ([*TO, "--cutoff", "-1"], "cutoff is -1"),
    "zero cutoff": ([*TO, "--cutoff", "0"], "cutoff is 0"),
    "NaN cutoff": ([*TO, "--cutoff", "nan"], "cutoff is nan"),
    "infinite cutoff": ([*TO, "--cutoff", "inf"], "cutoff is inf"),
    "text cutoff": ([*TO, "--cutoff", "fast"], "--cutoff.*number"),
    "cutoff too high": ([*TO, "--cutoff", "45"], "too high for data at 100 Hz"),
    "cutoff too low": ([*TO, "--cutoff", "0.01"], "filter"),
    "cutoff of no size": ([*TO, "--cutoff", "1e-300"], "filter|cutoff"),
    "validate cutoff too high": ([*VALIDATE, "--cutoff", "45"], "too high"),
    "validate NaN cutoff": ([*VALIDATE, "--cutoff", "nan"], "cutoff is nan"),
    "compare negative cutoff": ([*COMPARE, "--cutoff", "-3"], "cutoff is -3"),
    "inspect negative cutoff": (
        ["inspect", "good.csv", "--robot", "ur5", "--effects", "rigid_body", "--cutoff=-3"],
        "-3",
    ),
    "inspect cutoff alone": (["inspect", "good.csv", "--cutoff", "-3"], "cutoff is -3"),
    "too few gains": ([*TO, "--drive-gains", "1 2"], "2 drive gains, expected 6"),
    "zero gain": ([*TO, "--drive-gains", "1 1 1 1 1 0"], "other than zero"),
    "text gains": ([*TO, "--drive-gains", "a b"], "'a b'"),
    "NaN gain": ([*TO, "--drive-gains", "1 1 1 1 1 nan"], "finite"),
    "empty gains": ([*TO, "--drive-gains", " "], "--drive-gains"),
    "no gains at all": ([*TO, "--drive-gains", ""], "--drive-gains"),
    "gains for torques": ([*TO, "--drive-gains", "1 1 1 1 1 1"], "torque"),
    "columns out of range": ([*TO, "--columns", "time=0,q=1:7,tau=30:36"], "19 columns"),
    "columns overlap": ([*TO, "--columns", "time=0,q=1:7,tau=6:12"], "column 6"),
    "columns reversed": ([*TO, "--columns", "time=0,q=7:1,tau=13:19"], "7:1"),
    "columns empty range": ([*TO, "--columns", "time=0,q=1:1,tau=13:19"], "1:1"),
    "columns rubbish": ([*TO, "--columns", "hello"], "'hello'"),
    "columns empty": ([*TO, "--columns", ""], "columns"),
    "columns unknown channel": ([*TO, "--columns", "time=0,q=1:7,torque=13:19"], "torque"),
    "columns negative": ([*TO, "--columns", "time=-1,q=1:7,tau=13:19"], "time=-1"),
    "columns twice": ([*TO, "--columns", "time=0,q=1:7,q=1:7,tau=13:19"], "twice"),
    "columns without time": ([*TO, "--columns", "q=1:7,tau=13:19"], "no time"),
    "columns of a million": ([*TO, "--columns", "time=0,q=1:900000,tau=1:900000"], "column|19"),
    "columns other digits": ([*TO, "--columns", "time=٠,q=1:7,tau=13:19"], "time=٠"),
    "out in a missing folder": ([*IDENTIFY, "--out", "nowhere/out.json"], "folder that does not exist"),
    "out is a folder": ([*IDENTIFY, "--out", "."], "is a folder"),
    "out is empty": ([*IDENTIFY, "--out", ""], "folder|--out"),
    "out in a place that takes none": ([*IDENTIFY, "--out", "/proc/out.json"], "cannot be written"),
    "out below a file": ([*IDENTIFY, "--out", "good.csv/out.json"], "folder"),
    "out with an endless name": ([*IDENTIFY, "--out", "x" * 5000], "cannot be written|too long"),
    "out over its recording": ([*IDENTIFY, "--out", "good.csv"], "good.csv.*another"),
    "out over its robot": (["identify", "good.csv", "--robot", "arm.urdf", "--out", "./arm.urdf"], "arm.urdf.*another"),
    "plot of unknown ending": ([*VALIDATE, "--plot", "figure.gif"], "ending"),
    "plot of unknown ending after JSON": ([*VALIDATE, "--plot", "figure.gif", "--json", "out.json"], "ending"),
    "plot without ending": (["inspect", "good.csv", "--plot", "figure"], "ending"),
    "plot in a missing folder": (["inspect", "good.csv", "--plot", "nowhere/f.png"], "folder"),
    "plot in a missing folder after JSON": ([*VALIDATE, "--plot", "no/f.png", "--json", "out.json"], "folder"),
    "json over the model": ([*VALIDATE, "--json", "model.json"], "model.json.*another"),
    "json over the recording": ([*VALIDATE, "--json", "other.csv"], "other.csv.*another"),
    "json in a missing folder": ([*VALIDATE, "--json", "no/out.json"], "folder"),
    "compare json over the model": ([*COMPARE, "--json", "model.json"], "model.json.*another"),
    "model not found": (["validate", "other.csv", "--model", "nowhere.json"], "nowhere.json"),
    "model is a folder": (["validate", "other.csv", "--model", "."], "directory"),
    "model is the recording": (["validate", "other.csv", "--model", "other.csv"], "JSON"),
    "fitted recording": (["validate", "good.csv", "--model", "model.json"], "training recording of this model"),
    "one model": (["compare", "--model", "model.json", "--on", "other.csv"], "1 models given, expected two"),
    "nothing to compare on": (["compare", "--model", "model.json", "--model", "model.json"], "--on"),
    "compare on a fitted one": ([*COMPARE[:-1], "good.csv"], "fitted"),
    "diagnose no effects": (["diagnose", "good.csv", "--robot", "ur5", "--effects", ","], "--effects is ','"),
    "demo in a file": (["demo", "--folder", "good.csv"], "good.csv"),
    "demo below a file": (["demo", "--folder", "good.csv/demo"], "good.csv"),
    "demo in a place that takes none": (["demo", "--folder", "/proc/demo"], "/proc/demo"),
    "negative seed": (["demo", "--seed", "-1"], "seed"),
    "text seed": (["demo", "--seed", "x"], "seed"),
}


@pytest.mark.parametrize("case", OPTIONS)
def test_options(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    arguments, says = OPTIONS[case]
    fails(capfd, folder, arguments, says)


def test_no_traceback_from_the_installed_command(folder: Path) -> None:
    done = command(["identify", "nowhere.csv", "--robot", "ur5", "--out", "out.json"], folder)
    assert_one_line(done.returncode, done.stdout, done.stderr, "not found")


def test_the_unbroken_files_pass(folder: Path, capfd: pytest.CaptureFixture) -> None:
    """What every case breaks is good before: each failure above is of its own making."""
    assert run(["inspect", "good.csv", "other.csv", "--robot", "ur5", "--effects", "rigid_body"]) == 0
    assert run([*VALIDATE, "--json", "score.json", "--plot", "figure.png"]) == 0
    assert run(COMPARE) == 0
    for robot in ("arm.urdf", "arm.toml"):
        assert run(["base-parameters", "--robot", robot]) == 0
    told = capfd.readouterr().err.splitlines()
    # this motion does pass near one, and these efforts are made up
    true = ("near a singularity", "the efforts hold no gravity")
    assert [line for line in told if line and not any(text in line for text in true)] == []
