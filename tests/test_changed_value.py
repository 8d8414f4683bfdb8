"""A value that a model has, and that changed, is found though the model knows it from longer recordings; one that did not is not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.effects.catalogue import DEFAULT_EFFECTS
from tests.made_once import STEP
from tests.plant import Arm, Sensors, hide, multisine, record
from tests.plant.laws import Dry

pytestmark = pytest.mark.slow

JOINT = 3
CHANGE = 0.5  # of the value from before


def recorded(folder: Path, arm: Arm, seeds: tuple[int, ...]) -> list[pid.Recording]:
    for seed in seeds:
        record(arm, multisine(seed), Sensors(), seed, step=STEP).write_csv(folder / f"{seed}.csv")
    return [pid.load_recording(folder / f"{seed}.csv") for seed in seeds]


@pytest.fixture(scope="module")
def value() -> float:
    return 0.6 * float(Arm().friction.coulomb[JOINT - 1])


@pytest.fixture(scope="module")
def before(value: float) -> Arm:
    """An arm that sticks, with Stribeck friction on joint 3."""
    plain = Arm()
    return hide(replace(plain, friction=replace(plain.friction, law=Dry())), "stribeck_friction", JOINT, value)


def told(robot: pid.Robot, fitted: list[pid.Recording], asked: list[pid.Recording]) -> pid.Diagnosis:
    estimate = pid.identify(robot, fitted, effects=[*DEFAULT_EFFECTS, "stribeck_friction"])
    return pid.diagnose_motion(estimate, asked)


def test_one_recording_with_another_value_is_enough(tmp_path: Path, ur5: pid.Robot, before: Arm, value: float) -> None:
    after = hide(before, "stribeck_friction", JOINT, CHANGE * value)  # more of it
    diagnosis = told(ur5, recorded(tmp_path, before, (31, 33, 35)), recorded(tmp_path, after, (41,)))
    (found,) = diagnosis.causes
    assert (found.effect, found.joints) == ("stribeck_friction", (JOINT,))
    size = next(p for p in found.parameters if p.name == "stribeck_friction")
    assert size.change == pytest.approx(CHANGE * value, rel=0.4)


def test_three_recordings_with_the_same_value_change_nothing(tmp_path: Path, ur5: pid.Robot, before: Arm) -> None:
    diagnosis = told(ur5, recorded(tmp_path, before, (31,)), recorded(tmp_path, before, (51, 53, 55)))
    assert not np.any([f.grade == "cause" for f in diagnosis.findings])
