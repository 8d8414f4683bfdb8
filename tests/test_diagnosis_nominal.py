"""What a simulation from an arm's description alone gets wrong: found from its recordings, by name, size and order."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from tests.plant import Arm, Sensors, multisine, record

pytestmark = pytest.mark.slow

GAIN = 10.0  # N m/A


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Two recordings of an arm with the description's links, and friction and rotors that no description has."""
    folder, paths = tmp_path_factory.mktemp("nominal"), []
    for seed in (1, 3):
        path = folder / f"run_{seed}.csv"
        record(Arm(), multisine(seed), Sensors(), seed, step=2e-3).write_csv(path)
        head, *rows = path.read_text(encoding="utf-8").splitlines()
        names = head.split(",")
        efforts = [k for k, name in enumerate(names) if name.startswith("tau_")]
        table = np.array([[float(x) for x in row.split(",")] for row in rows])
        table[:, efforts] /= GAIN
        np.savetxt(
            path,
            table,
            delimiter=",",
            comments="",
            header=head.replace("tau_", "current_"),
            fmt="%.9g",
            encoding="utf-8",
        )
        paths.append(str(path))
    return paths


@pytest.fixture(scope="module")
def answer(runs: list[str], tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, Path]:
    folder = tmp_path_factory.mktemp("answer")
    gains = " ".join([str(GAIN)] * 6)
    code = run(
        ["diagnose", "--robot", "ur5", "--drive-gains", gains, "--cutoff", "5", runs[0],
         "--json", str(folder / "found.json"), "--out", str(folder / "extended.json")]
    )  # fmt: skip
    assert code == 0
    return json.loads((folder / "found.json").read_text(encoding="utf-8")), folder / "extended.json"


def test_the_friction_that_a_description_lacks_is_found_on_every_joint(answer: tuple[dict, Path]) -> None:
    found, _ = answer
    assert found["question"] == "nominal"
    friction = {"coulomb_friction", "viscous_friction", "nonlinear_viscous_friction", "stribeck_friction",
                "presliding_hysteresis"}  # fmt: skip
    joints = {j for f in found["findings"] if f["effect"] in friction for j in f["joints"]}
    assert joints == {1, 2, 3, 4, 5, 6}
    assert found["model"]["effects"] == pid.Model.nominal(pid.load_robot("ur5"), ["rigid_body"]).as_dict()["effects"]


def test_what_scales_friction_that_a_description_lacks_is_no_open_question(answer: tuple[dict, Path]) -> None:
    """Every joint moves by radians, and there is nothing to scale."""
    unseen = answer[0]["unseen"]
    assert unseen
    assert not [one for one in unseen if one["reason"] == "of a joint that moves too little"]
    assert "friction_level" not in {one["effect"] for one in unseen}


def test_the_extended_model_predicts_a_run_that_nothing_saw(answer: tuple[dict, Path], runs: list[str]) -> None:
    """It remembers gains and cutoff: the second recording is read by itself."""
    extended = pid.load_estimate(answer[1])
    assert extended.drive_gains == (GAIN,) * 6
    assert extended.filter.cutoff == 5
    unseen = pid.load_recording(runs[1])
    after = pid.validate(extended, [unseen])
    bare = pid.Model.nominal(extended.model.robot, ["rigid_body"])
    assert len(extended.theta) > len(bare.theta)
    signals = pid.prepare(unseen.with_drive_gains((GAIN,) * 6), extended.filter)
    assert signals.torque is not None
    bare_rms = np.sqrt(np.mean((signals.torque - bare.torque(signals)) ** 2, axis=0))
    assert (after.rms < 0.5 * bare_rms).all()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "expected either --model"),
        (["--model", "m.json", "--robot", "ur5"], "expected either --model"),
        (["--model", "m.json", "--effects", "viscous_friction"], "expected --effects with --robot only"),
        (["--robot", "ur6"], "robot 'ur6' not found"),
        (["--robot", "ur5", "--effects", "friction"], "friction"),
    ],
)
def test_a_model_is_named_once(
    arguments: list[str], said: str, runs: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["diagnose", *arguments, runs[0]]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1


def test_the_description_as_input_is_not_written_over(runs: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["diagnose", "--robot", runs[1], runs[0], "--out", runs[1]]) == 2
    assert "also read by this command" in capsys.readouterr().err


def test_columns_belong_to_a_model_that_has_none(runs: list[str], answer: tuple[dict, Path]) -> None:
    with pytest.raises(pid.InputError, match="columns were given beside an estimate"):
        pid.diagnose_motion(pid.load_estimate(answer[1]), [pid.load_recording(runs[1])], columns="time=0,q=1:7")
