"""Ripple of a motor, some periods in each of its turns: behind the gear it is so fast that only slow motion shows it below a cutoff."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import physident as pid
from tests.plant import Arm, Drives, Ripple, Sensors, multisine, record

PAIRS = 5  # of poles: an offset of the current sensor makes as many periods in a turn of the motor
SIZE, PHASE = 2.5, 0.7  # N m, rad
JOINT = 6  # nearly all its torque is friction: a scale of it is no other name of the ripple


def test_it_is_found_at_its_order_size_and_phase(ur5: pid.Robot, tmp_path: Path) -> None:
    assert ur5.drives is not None
    order = PAIRS * ur5.drives[JOINT - 1].gear_ratio
    arm = replace(Arm(), drives=Drives(ripples=(Ripple(JOINT - 1, SIZE, order, PHASE),)))
    record(arm, multisine(3, speed=0.3), Sensors(), 3, step=2e-3).write_csv(tmp_path / "slow.csv")
    slow = pid.load_recording(tmp_path / "slow.csv")

    first = pid.diagnose_motion(pid.identify(ur5, slow, filter=pid.Filter(8.0)), slow).causes[0]

    assert (first.effect, first.joints, first.rivals) == ("torque_ripple", (JOINT,), ())
    values = {v.name: v.value for v in first.parameters}
    assert values["order"] == order
    np.testing.assert_allclose(
        [values["sin"], values["cos"]], [SIZE * np.cos(PHASE), SIZE * np.sin(PHASE)], atol=0.05 * SIZE
    )
    assert f"{PAIRS} times in each turn of its motor" in first.in_words
