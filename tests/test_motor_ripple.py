"""Ripple of a motor, some periods in each of its turns: behind the gear it is so fast that only slow motion shows it below a cutoff."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.rivals.same_torque import same_torque
from physident.diagnosis.search.forward_search import search_effects
from physident.effects.catalogue import effect_from_dict
from physident.estimation.identify import prepare_all
from tests.plant import Arm, Drives, Ripple, Sensors, multisine, record

pytestmark = pytest.mark.slow

PAIRS = 5  # of poles: an offset of the current sensor makes as many periods in a turn of the motor
SIZE, PHASE = 2.5, 0.7  # N m, rad
JOINT = 6  # nearly all its torque is friction


@pytest.fixture(scope="module")
def slow(ur5: pid.Robot, tmp_path_factory: pytest.TempPathFactory) -> pid.Recording:
    assert ur5.drives is not None
    order = PAIRS * ur5.drives[JOINT - 1].gear_ratio
    arm = replace(Arm(), drives=Drives(ripples=(Ripple(JOINT - 1, SIZE, order, PHASE),)))
    path = tmp_path_factory.mktemp("slow") / "slow.csv"
    record(arm, multisine(3, speed=0.3), Sensors(), 3, step=2e-3).write_csv(path)
    return pid.load_recording(path)


@pytest.fixture(scope="module")
def estimate(ur5: pid.Robot, slow: pid.Recording) -> pid.Estimate:
    return pid.identify(ur5, slow, filter=pid.Filter(8.0))


def test_it_is_found_at_its_order_size_and_phase(ur5: pid.Robot, slow: pid.Recording, estimate: pid.Estimate) -> None:
    assert ur5.drives is not None
    first = pid.diagnose_motion(estimate, slow).causes[0]
    assert (first.effect, first.joints) == ("torque_ripple", (JOINT,))
    values = {v.name: v.value for v in first.parameters}
    assert values["order"] == PAIRS * ur5.drives[JOINT - 1].gear_ratio
    np.testing.assert_allclose(
        [values["sin"], values["cos"]], [SIZE * np.cos(PHASE), SIZE * np.sin(PHASE)], atol=0.05 * SIZE
    )
    assert f"{PAIRS} times in each turn of its motor" in first.in_words


def test_a_scale_of_all_torque_of_its_joint_is_no_other_name_for_it(
    ur5: pid.Robot, slow: pid.Recording, estimate: pid.Estimate
) -> None:
    """What the scale has beside the model's own parameters is the ripple itself, where the ripple counts as the joint's torque."""
    problem = state_problem("missing", estimate, prepare_all(ur5, [slow], estimate.filter), estimate.filter, 0)
    found = search_effects(problem).last.hypothesis
    alike = same_torque(replace(found, problem=replace(problem, barred=frozenset())))
    assert alike["torque_ripple", (JOINT,)] == []


@pytest.fixture(scope="module")
def urdf(ur5: pid.Robot, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("urdf") / "arm.urdf"
    path.write_text(ur5.urdf, encoding="utf-8")
    return path


@pytest.mark.parametrize("stated", [True, False])
def test_a_urdf_has_no_gear_ratios_until_they_are_stated(
    ur5: pid.Robot, urdf: Path, slow: pid.Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str], stated: bool
) -> None:
    assert ur5.drives is not None
    ratios = " ".join(str(drive.gear_ratio) for drive in ur5.drives)
    model, found = tmp_path / "model.json", tmp_path / "found.json"
    options = ["--gear-ratios", ratios] if stated else []
    assert run(["identify", slow.source, "--robot", str(urdf), "--cutoff", "8", *options, "--out", str(model)]) == 0
    capsys.readouterr()
    assert run(["diagnose", "--model", str(model), slow.source, "--json", str(found)]) == 0
    told = " ".join(capsys.readouterr().out.split())
    orders = [
        value["value"]
        for one in json.loads(found.read_text(encoding="utf-8"))["findings"]
        for value in one["parameters"]
        if (one["effect"], value["name"]) == ("torque_ripple", "order")
    ]
    assert (orders == [PAIRS * ur5.drives[JOINT - 1].gear_ratio]) is stated
    assert (f"{PAIRS} times in each turn of its motor" in told) is stated
    assert ("ripple of the motors behind their gears was not searched" in told) is not stated


@pytest.mark.parametrize(
    ("ratios", "told"),
    [
        ((101.0,) * 5, "5 gear ratios came, expected 6"),
        ((101.0,) * 5 + (0.0,), "expected numbers from 1 to 10000"),
        ((101.0,) * 5 + (1e300,), "expected numbers from 1 to 10000"),
        ((101.0,) * 5 + (np.nan,), "expected numbers from 1 to 10000"),
    ],
)
def test_gear_ratios_are_those_of_gears_and_one_a_joint(urdf: Path, ratios: tuple[float, ...], told: str) -> None:
    with pytest.raises(pid.InputError, match=told):
        pid.load_robot(urdf, gear_ratios=ratios)


def test_a_motor_that_turns_the_other_way_ripples_alike(urdf: Path) -> None:
    assert pid.load_robot(urdf, gear_ratios=(-48.0,) * 6).motor_turns == (48.0,) * 6


@pytest.mark.parametrize("ratio", [50.7, 99.9, 120.9])
@pytest.mark.parametrize("periods", [1, 3, 12])
def test_a_ratio_need_not_be_whole(urdf: Path, ratio: float, periods: int) -> None:
    """The order that was searched is told in turns of the motor, whatever the ratio."""
    robot = pid.load_robot(urdf, gear_ratios=(ratio,) * 6)
    cls = pid.CATALOGUE["torque_ripple"]
    (shape,) = cls.shape_parameters
    order = min(cls.search_grid(robot, (JOINT,), shape), key=lambda one: abs(one - periods * ratio))
    often = {1: "once"}.get(periods, f"{periods} times")
    ripple = effect_from_dict({"effect": "torque_ripple", "joints": [JOINT], "order": [order]})
    assert f"{often} in each turn of its motor" in ripple.in_words(robot, np.array([1.0, 0.0]))


def test_a_description_that_states_its_drives_is_not_contradicted() -> None:
    with pytest.raises(pid.InputError, match=r"ur5\.toml states them already \(101 101 101 101 101 101\)"):
        pid.load_robot("ur5", gear_ratios=(50.0,) * 6)
