"""A new payload loaded no gear before it was there: what grows with the load is compared at the loads of its own time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import physident as pid
from physident.diagnosis.grading.control import changes_of
from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.estimation.identify import prepare_all
from tests.serial_arms import Joint, swinging, urdf

ARM = (Joint(mass=5.0), Joint(mass=2.5))
LOADED = (Joint(mass=5.0), Joint(mass=7.0))  # as with a body of the rod's shape at its end
DRY, NOISE = np.array([2.0, 1.0]), 0.1  # N m


def run(joints: tuple[Joint, ...], share: float, number: int) -> pid.Recording:
    """Thirty seconds by pinocchio, with dry friction that grows with what the gears carry."""
    rng, time = np.random.default_rng(number), np.arange(0.0, 30.0, 0.004)
    q, v, tau = swinging(rng, time, joints, 0.5, (0.4, 4.0))
    rubs: NDArray[np.float64] = (DRY + share * np.abs(tau)) * v / np.hypot(v, 0.004)
    return pid.Recording.from_arrays(
        time, q, dq=v, effort=tau + rubs + NOISE * rng.standard_normal(tau.shape), source=str(number)
    )


@pytest.mark.parametrize(("after", "changed"), [(0.1, False), (0.3, True)])
def test_friction_by_load_that_was_there_before_a_payload_has_not_changed(
    tmp_path: Path, after: float, changed: bool
) -> None:
    (tmp_path / "arm.urdf").write_text(urdf(ARM))
    robot = pid.load_robot(tmp_path / "arm.urdf")
    before = [run(ARM, 0.1, number) for number in (1, 2, 3)]
    estimate = pid.identify(robot, before)
    asked = [run(LOADED, after, number) for number in (4, 5, 6)]
    signals, control = (prepare_all(robot, some, estimate.filter) for some in (asked, before))
    problem = state_problem("different", estimate, signals, estimate.filter, 0)
    wanted = [("payload", ()), ("load_dependent_friction", (1,)), ("load_dependent_friction", (2,))]
    candidates = {one.key: one for one in settled_hypothesis(problem, ()).data.candidates}
    accepted = [
        AcceptedEffect(candidates[key], effect)
        for key in wanted
        if (effect := candidates[key].options[0].effect) is not None
    ]
    payload, *friction = changes_of(settled_hypothesis(problem, accepted), control, range(3))
    assert payload.size == pytest.approx(1.0, abs=0.15)
    assert [one.size > 0 for one in friction] == [changed] * 2
