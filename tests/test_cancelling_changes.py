"""Friction of one joint that only builds up differently: two values of the model change, and hardly any friction is lost or gained."""

from __future__ import annotations

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.grading.one_story import is_cancelled
from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.effects.friction import CoulombFriction
from physident.effects.hysteresis import PreslidingHysteresis
from physident.estimation.identify import prepare_all

ARM = """<robot name="jib"><link name="mast"/>
  <link name="jib"><inertial><mass value="4.2"/><origin xyz="0.3 0 0"/>
    <inertia ixx="0.02" iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="luff" type="revolute"><parent link="mast"/><child link="jib"/><axis xyz="0 -1 0"/>
    <limit lower="-1.5" upper="1.5" effort="80" velocity="3"/></joint></robot>"""
INERTIA, MOMENT = 0.2 + 4.2 * 0.3**2, 4.2 * 0.3  # kg m^2, kg m
SLIP, AT_ONCE, BUILT_UP = 0.02, 1.1, 3.2  # rad, N m, N m


def run(number: int, moved: float = 0.0, lost: float = 0.0) -> pid.Recording:
    """Thirty seconds; of the friction that builds up ``moved`` [N m] turn at once instead, and ``lost`` [N m] are gone."""
    rng, time = np.random.default_rng(number), np.arange(0.0, 30.0, 0.004)
    size, omega, phase = rng.uniform(0.05, 0.35, 4), rng.uniform(0.4, 4.0, 4), rng.uniform(0, 2 * np.pi, 4)
    angle = time[:, None] * omega + phase
    q, v, a = (
        (size * part).sum(axis=1) for part in (np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle))
    )
    stretch, built_up = 0.0, []
    for step in np.diff(q, prepend=q[0]):
        stretch += step - abs(step) * stretch / SLIP
        built_up.append(stretch / SLIP)
    torque = INERTIA * a + 9.81 * MOMENT * np.cos(q) + 1.3 * v
    torque += (AT_ONCE + moved) * np.sign(v) + (BUILT_UP - moved - lost) * np.array(built_up)
    effort = torque + 0.08 * rng.standard_normal(len(time))
    return pid.Recording.from_arrays(time, q[:, None], dq=v[:, None], effort=effort[:, None], source=str(number))


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> pid.Estimate:
    path = tmp_path_factory.mktemp("jib") / "jib.urdf"
    path.write_text(ARM)
    effects = pid.make_effects(("rigid_body", "viscous_friction", "coulomb_friction", "torque_offset"))
    bristles = PreslidingHysteresis(distance=(SLIP,))
    return pid.identify(pid.load_robot(path), [run(k) for k in (1, 2, 3)], [*effects, bristles])


@pytest.mark.parametrize(
    ("change", "cancel"), [({"moved": 2.1}, True), ({"lost": 2.1}, False), ({"moved": 0.9, "lost": 1.5}, False)]
)
def test_only_friction_that_is_neither_lost_nor_gained_cancels(
    model: pid.Estimate, change: dict[str, float], cancel: bool
) -> None:
    signals = prepare_all(model.model.robot, [run(k, **change) for k in (4, 5)], model.filter)
    problem = state_problem("different", model, signals, model.filter, 0)
    candidates = {one.key: one for one in settled_hypothesis(problem, ()).data.candidates}
    laws = (CoulombFriction(), PreslidingHysteresis(distance=(SLIP,)))
    both = settled_hypothesis(problem, [AcceptedEffect(candidates[law.name, (1,)], law) for law in laws])
    at_once, built_up = (float(one[0]) for one in both.effect_values)
    assert at_once == pytest.approx(change.get("moved", 0.0), abs=0.2)
    assert SLIP * built_up == pytest.approx(-sum(change.values()), abs=0.3)
    assert [is_cancelled(both, [i]) for i in (0, 1)] == [cancel] * 2
