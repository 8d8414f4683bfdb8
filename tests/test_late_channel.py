"""The torque of one joint is reported late: named with its delay, one clock for all where every joint is late, and no bristle is taken for it."""

from __future__ import annotations

from pathlib import Path

import pytest

import physident as pid
from tests.made_once import STEP
from tests.plant import Arm, Sensors, hide, multisine, record

pytestmark = pytest.mark.slow

LATE = 0.012  # s


def recorded(folder: Path, arm: Arm, *seeds: int) -> list[pid.Recording]:
    """Recordings of an arm, each of another motion."""
    for seed in seeds:
        record(arm, multisine(seed), Sensors(), seed, step=STEP).write_csv(folder / f"{seed}.csv")
    return [pid.load_recording(folder / f"{seed}.csv") for seed in seeds]


@pytest.mark.parametrize("joint", [1, 3])
def test_a_late_channel_is_named_with_its_delay(joint: int, healthy_estimate: pid.Estimate, tmp_path: Path) -> None:
    runs = recorded(tmp_path, hide(Arm(), "torque_delay", joint, LATE), 61, 63)
    found = pid.diagnose_motion(healthy_estimate, runs)
    assert [(f.effect, f.joints) for f in found.causes] == [("torque_delay", (joint,))], repr(found)
    (delay,) = found.causes[0].parameters
    assert delay.unit == "s"
    assert delay.change == pytest.approx(LATE, rel=0.1)
    told = f"The torque reading of joint {joint} comes {1000 * delay.value:.2g} ms after its motion"
    assert told in " ".join(repr(found).split())


def test_channels_that_are_all_late_are_one_clock(healthy_estimate: pid.Estimate, tmp_path: Path) -> None:
    found = pid.diagnose_motion(healthy_estimate, recorded(tmp_path, hide(Arm(), "time_delay", (), LATE), 65, 67))
    assert [f.effect for f in found.causes] == ["time_delay"], repr(found)
    assert found.causes[0].parameters[0].change == pytest.approx(LATE, rel=0.1)


def test_friction_that_builds_up_over_a_distance_is_no_late_channel(
    healthy_estimate: pid.Estimate, tmp_path: Path
) -> None:
    """A bristle lags, too, but by a distance, and only its own torque."""
    arm = hide(Arm(), "presliding_hysteresis", 2, 8.0 / 0.003, slip=0.003)
    found = pid.diagnose_motion(healthy_estimate, recorded(tmp_path, arm, 69, 71))
    assert [(f.effect, f.joints) for f in found.causes] == [("presliding_hysteresis", (2,))], repr(found)
    assert "torque_delay" not in {f.effect for f in found.findings}
