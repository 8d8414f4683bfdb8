"""Ripple of a motor, some periods in each of its turns: behind the gear it is so fast that only slow motion shows it below a cutoff."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.rivals.same_torque import same_torque
from physident.diagnosis.search.forward_search import search_effects
from physident.estimation.identify import prepare_all
from tests.plant import Arm, Drives, Ripple, Sensors, multisine, record

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
