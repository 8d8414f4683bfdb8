"""What the model always lacked takes up a change of its kind in a fit; the change is still told with all that it explains."""

from __future__ import annotations

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.result.findings import Finding

QUILL = """<robot name="quill"><link name="column"/>
  <link name="quill"><inertial><mass value="2.4"/><origin xyz="0 0 -0.1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="chuck"><inertial><mass value="0.5"/><origin xyz="0.05 0 -0.03"/>
    <inertia ixx="0.003" iyy="0.003" izz="0.003" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="lift" type="prismatic"><parent link="column"/><child link="quill"/><axis xyz="0 0 1"/>
    <limit lower="-0.2" upper="0.2" effort="150" velocity="1"/></joint>
  <joint name="turn" type="revolute"><parent link="quill"/><child link="chuck"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="6" velocity="4"/></joint></robot>"""
LIFTED, TURNED = 2.9, 0.003 + 0.5 * 0.05**2  # kg, kg m^2 about the chuck's axis
BEFORE, AFTER, PER_LOAD = 9.0, 14.0, 0.1  # N that rubs, and N for each N that the quill's drive carries
ORDINARY = ("rigid_body", "viscous_friction", "coulomb_friction")


def recorded(seed: int, rubs: float) -> pid.Recording:
    """A quill that lifts while its chuck turns, whose drive rubs by a level and by what it carries; rigid forces in closed form."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 40.0, 0.004)
    omega, phase = rng.uniform(0.8, 5.0, (4, 2)), rng.uniform(0, 2 * np.pi, (4, 2))
    angle = time[:, None, None] * omega + phase
    size = np.array([0.03, 0.3])
    q, v, a = (size * part.sum(axis=1) for part in (np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle)))
    carried = LIFTED * (9.81 + a[:, 0])
    force = carried + 30.0 * v[:, 0] + (rubs + PER_LOAD * np.abs(carried)) * np.clip(v[:, 0] / 1e-4, -1, 1)
    turn = TURNED * a[:, 1] + 0.02 * v[:, 1] + 0.1 * np.clip(v[:, 1] / 1e-3, -1, 1)
    noise = rng.standard_normal((len(time), 2)) * (0.5, 0.01)
    return pid.Recording.from_arrays(time, q, dq=v, effort=np.column_stack([force, turn]) + noise, source=f"{seed}")


@pytest.fixture(scope="module")
def answer(tmp_path_factory: pytest.TempPathFactory) -> pid.Diagnosis:
    path = tmp_path_factory.mktemp("quill") / "quill.urdf"
    path.write_text(QUILL)
    control = [recorded(seed, BEFORE) for seed in (1, 2)]
    model = pid.identify(pid.load_robot(path), control, pid.make_effects(ORDINARY))
    return pid.diagnose_motion(model, [recorded(seed, AFTER) for seed in (3, 4)], before=control)


def test_friction_that_grew_beside_friction_that_was_never_modelled_is_the_cause(answer: pid.Diagnosis) -> None:
    (cause,) = [one for one in answer.findings if one.grade == "cause"]
    assert (cause.effect, cause.joints) == ("coulomb_friction", (1,))
    (value,) = [one for one in cause.parameters if one.name == "coulomb_friction"]
    assert value.change == pytest.approx(AFTER - BEFORE, rel=0.1)
    assert [(old.effect, old.joints) for old in answer.missing_since_before] == [("load_dependent_friction", (1,))]


def test_it_takes_the_whole_change_as_a_fit_without_the_other_would(answer: pid.Diagnosis) -> None:
    cause: Finding = next(one for one in answer.findings if one.grade == "cause")
    size = AFTER - BEFORE  # N, root mean square of a force that only changes its sign
    assert cause.gain.rms_before == pytest.approx(size, rel=0.1)
    assert (cause.takes_percent or 0.0) > 90
