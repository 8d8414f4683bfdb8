"""A format with damping and dry friction gets those nearest to a joint's friction; nothing of the friction is lost."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import nnls

import physident as pid
from physident.effects.friction import FrictionAsymmetry, NonlinearViscousFriction, StribeckFriction
from physident.effects.learned.velocity_curve import LearnedVelocity
from physident.estimation.estimate import as_estimate
from physident.export.mjcf.callback import with_callback
from physident.export.mjcf.mjcf import mjcf_of
from physident.export.urdf import urdf_of
from physident.replay.replay import replay
from tests.exported_arms import physical_model
from tests.mujoco_torque import inverse_dynamics

Array = np.ndarray


def bent(seed: int) -> pid.Model:
    """A UR5 with curved friction: on joint 1 steep damping against a negative one, as fits with both may leave it."""
    robot = pid.load_robot("ur5")
    plain = physical_model(robot, seed)
    effects = (
        *(effect for effect in plain.effects if effect.name != "torque_offset"),
        NonlinearViscousFriction((1, 4), (0.9, 2.5)),
        StribeckFriction((2,), (0.1,)),
        FrictionAsymmetry((3,)),
    )
    theta = np.concatenate([plain.theta[:78], [60.0, -0.5, 4.0, 0.7]])
    theta[66] = -50.0
    theta[60:66] += 0.5
    return pid.Model(robot, effects, theta)


def sliding(model: pid.Model, joint: int, speeds: Array) -> Array:
    """Friction at constant speeds of one joint (from 1), the mean of both directions, by the torque alone."""
    v = np.zeros((len(speeds), model.robot.n))
    v[:, joint - 1] = speeds
    torques = [model.torque(pid.Signals.of_states(np.zeros_like(v), sign * v, np.zeros_like(v))) for sign in (1, -1)]
    return 0.5 * (torques[0] - torques[1])[:, joint - 1]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_no_other_damping_and_dry_friction_is_nearer(seed: int) -> None:
    import mujoco

    model = bent(seed)
    compiled = mujoco.MjModel.from_xml_string(mjcf_of(model).text)
    assert (compiled.dof_damping >= 0).all()
    assert (compiled.dof_frictionloss >= 0).all()
    for joint in (1, 2, 4):
        v = np.linspace(0, model.robot.velocity_limit[joint - 1] / 3, 101)[1:]
        inertia = pid.Model(model.robot, model.effects[:2], model.theta[:66])
        wanted = sliding(model, joint, v) - sliding(inertia, joint, v)

        def error(damping: float, dry: float, v: Array = v, wanted: Array = wanted) -> float:
            return float(((damping * v + dry - wanted) ** 2).sum())

        damping, dry = compiled.dof_damping[joint - 1], compiled.dof_frictionloss[joint - 1]
        least = error(damping, dry)
        for change in np.random.default_rng(seed).normal(size=(200, 2)) * 0.02:
            assert error(max(damping + change[0], 0.0), max(dry + change[1], 0.0)) >= least * (1 - 1e-9)
    plain = physical_model(model.robot, seed)
    for joint in (3, 5, 6):  # an asymmetry has no part that is alike in both directions, so these stay as they are
        assert compiled.dof_damping[joint - 1] == plain.parameters("viscous_friction")[joint - 1]
        assert compiled.dof_frictionloss[joint - 1] == plain.parameters("coulomb_friction")[joint - 1]
    stated = [text for text in mjcf_of(model).stated if text.startswith("friction of joint")]
    assert [text[:19] for text in stated] == [f"friction of joint {j}" for j in (1, 2, 4)]


@dataclass(frozen=True)
class Film(pid.FormulaEffect):
    """Friction as a user may state it: a film that drags most at 0.3 rad/s."""

    name = "film"
    unit = "N m"
    family = pid.Family.FRICTION
    formulas = ("v / 0.3 / (1 + (v / 0.3) ** 2)",)
    passive = True


@pytest.mark.parametrize("effect", [LearnedVelocity((1,), (-3.0,), (3.0,), (20.0,)), Film((1,))])
def test_friction_that_was_learned_or_stated_by_a_formula_is_approximated_too(effect: Any) -> None:
    import mujoco

    plain = physical_model(pid.load_robot("ur5"), 7)
    kept = tuple(one for one in plain.effects if one.name != "torque_offset")
    # of the curve only what is odd is friction of both directions: a part of it at each of its modes
    values = np.random.default_rng(3).uniform(2.0, 4.0, len(effect.columns(plain.robot)))
    model = pid.Model(plain.robot, (*kept, effect), np.concatenate([plain.theta[:78], values]))
    compiled = mujoco.MjModel.from_xml_string(mjcf_of(model).text)
    v = np.linspace(0, model.robot.velocity_limit[0] / 3, 101)[1:]
    inertia = pid.Model(model.robot, kept[:2], model.theta[:66])
    wanted = sliding(model, 1, v) - sliding(inertia, 1, v)
    laws = np.column_stack([v, np.ones_like(v)])
    nearest, error = nnls(laws, wanted)
    bare = model.parameters("viscous_friction")[0], model.parameters("coulomb_friction")[0]
    np.testing.assert_allclose([compiled.dof_damping[0], compiled.dof_frictionloss[0]], nearest, rtol=1e-6)
    assert error < 0.7 * np.linalg.norm(wanted - laws @ bare)


def test_file_and_callback_are_the_whole_model() -> None:
    import mujoco

    from physident.export.mjcf.callback import callback_of
    from physident.identifiability.base_parameters import random_motion

    model = bent(4)
    held = mjcf_of(model).held
    states = random_motion(model.robot, seed=5, count=40)
    np.testing.assert_allclose(with_callback(held).model.torque(states), model.torque(states), atol=1e-9)
    source = callback_of(model, held)
    assert source is not None
    space: dict = {}
    exec(source, space)
    compiled = mujoco.MjModel.from_xml_string(mjcf_of(model).text)
    dry = compiled.dof_frictionloss * np.tanh(states.v / 1e-3)
    try:
        space["install"](compiled)
        found = inverse_dynamics(compiled, states, model.robot.joint_names) + dry
    finally:
        mujoco.set_mjcb_passive(None)
    expected = model.torque(states)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
    # without the callback the file is nearer than one that leaves out what it cannot hold
    kept = replace(model, theta=np.where(np.arange(len(model.theta)) < 78, model.theta, 0.0))
    clipped = replace(kept, theta=np.where(kept.theta == -50.0, 0.0, kept.theta))
    errors = [np.abs(part.torque(states) - expected)[:, 0].mean() for part in (held.model, clipped)]
    assert errors[0] < 0.3 * errors[1]
    assert urdf_of(model).folded == mjcf_of(model).held.folded


@pytest.mark.slow
def test_both_simulators_have_the_same_friction() -> None:
    model = bent(6)
    model = replace(model, theta=np.concatenate([model.robot.nominal, model.theta[60:]]))
    recording = pid.simulate(model, pid.random_trajectory(model.robot, seed=7, duration=10.0))
    scores = [
        replay(as_estimate(model, pid.Filter()), None, [recording], simulator).replay.before  # pyright: ignore[reportArgumentType]
        for simulator in ("mujoco", "physident")
    ]
    moved = np.ptp(recording.q, axis=0)
    assert all((score.position < 0.02 * moved).all() for score in scores)
