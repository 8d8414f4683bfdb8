"""A spring that is relaxed elsewhere than at zero, as nearly every cable and hose is: one cause, whose offset says where."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import physident as pid
from tests.plant import Arm, Sensors, hide, multisine, record

pytestmark = pytest.mark.slow

JOINT, STIFFNESS, RELAXED = 1, 12.0, 0.5  # N m/rad, rad


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Arm, int], pid.Recording]:
    folder = tmp_path_factory.mktemp("relaxed")

    def made(arm: Arm, seed: int) -> pid.Recording:
        record(arm, multisine(seed), Sensors(), seed, step=2e-3).write_csv(folder / f"{seed}.csv")
        return pid.load_recording(folder / f"{seed}.csv")

    return made


def test_a_spring_and_where_it_is_relaxed_are_one_cause(
    ur5: pid.Robot, run: Callable[[Arm, int], pid.Recording]
) -> None:
    healthy = Arm()
    estimate = pid.identify(ur5, [run(healthy, seed) for seed in (31, 32)])
    pulled = hide(hide(healthy, "joint_spring", (JOINT,), STIFFNESS), "torque_offset", (JOINT,), -STIFFNESS * RELAXED)
    found = pid.diagnose_motion(estimate, [run(pulled, seed) for seed in (33, 34)])
    (cause,) = found.causes
    assert (cause.effect, cause.joints) == ("joint_spring", (JOINT,))
    assert cause.parameters[0].value == pytest.approx(STIFFNESS, rel=0.1)
    (offset,) = [one for one in found.findings if one.effect == "torque_offset"]
    assert (offset.grade, offset.joints) == ("contribution", (JOINT,))
    assert -offset.parameters[0].change / cause.parameters[0].value == pytest.approx(RELAXED, abs=0.1)
    assert "what joint_spring (joint 1) leaves of one torque" in " ".join(str(found).split())
