"""The simulated arm against an independent engine and conservation laws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.effects.friction import CoulombFriction
from physident.simulation.controllers import PD, ComputedTorque, Released
from physident.simulation.integrate import integrate
from tests.simulated_arm import COULOMB, POSE, ROTOR, SMOOTH, VISCOUS, arm, drive, energy, frictionless, resting


def mujoco_ur5(robot: pid.Robot, friction: np.ndarray, step: float):
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(robot.urdf)
    model.opt.timestep, model.opt.gravity = step, robot.gravity
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    model.opt.tolerance = 1e-12
    model.dof_armature[:], model.dof_damping[:], model.dof_frictionloss[:] = ROTOR, VISCOUS, friction
    model.dof_solref[:], model.dof_solimp[:] = [2 * step, 1], [0.99, 0.999, 0.001, 0.5, 2]
    return mujoco, model, mujoco.MjData(model)


def test_inverse_dynamics_equal_mujoco(ur5):
    mujoco, model, data = mujoco_ur5(ur5, np.zeros(6), 1e-3)
    q, v, a = np.random.default_rng(0).standard_normal((3, 20, 6))
    own = replace(arm(ur5), theta=np.concatenate([ur5.nominal, ROTOR, VISCOUS, np.zeros(6)]))
    torque = own.torque(pid.Signals.of_states(q, v, a))
    for k in range(len(q)):
        data.qpos, data.qvel, data.qacc = q[k], v[k], a[k]
        mujoco.mj_inverse(model, data)
        np.testing.assert_allclose(data.qfrc_inverse, torque[k], atol=1e-8)


def test_forward_dynamics_equal_mujoco(ur5):
    # MuJoCo has a hard sign, and an error of first order in its step: hence a short distance here and a short step there
    model, hard = arm(ur5, CoulombFriction()), arm(ur5, CoulombFriction(presliding=1e-7))
    motion = pid.random_trajectory(ur5, seed=1, harmonics=3, base_frequency=0.2)
    planned = integrate(model, motion, ComputedTorque(), step=0.002)

    def torque(time):
        return np.array([np.interp(time, planned.time, column) for column in drive(planned).T]).T

    start = resting(planned.q[0], 2.0)
    own = integrate(hard, start, Released(), lambda time, q, v: torque(time), step=0.0005)
    step = 2.5e-5
    mujoco, engine, data = mujoco_ur5(ur5, COULOMB, step)
    data.qpos = own.q[0]
    for data.qfrc_applied[:] in torque(step * (np.arange(round(2.0 / step)) + 0.5)):
        mujoco.mj_step(engine, data)
    # a stuck joint is let go at slightly other instants: by the bristle's force here, by a constraint of finite stiffness there
    np.testing.assert_allclose(data.qpos, own.q[-1], atol=2e-3)
    assert np.ptp(own.q, axis=0).min() > 0.1  # every joint moved
    assert (np.abs(np.diff(np.sign(own.v), axis=0)) > 1).any(axis=0).sum() > 3  # and most of them turned back


@pytest.mark.parametrize(("rotor", "duration"), [(ROTOR, 20.0), (np.zeros(6), 3.0)])
def test_energy_is_conserved(ur5, rotor, duration):
    """Without rotors the wrist whips round at 100 rad/s and more: shorter, but not kinder."""
    states = integrate(frictionless(ur5, rotor), resting(POSE, duration), Released())
    total = energy(frictionless(ur5, rotor), states, rotor)
    exchanged = np.ptp([pin.computePotentialEnergy(ur5.pinocchio, ur5.pinocchio.createData(), q) for q in states.q])
    assert exchanged > 10.0  # J: it did fall and swing
    assert np.abs(total - total[0]).max() < 1e-4 * exchanged


def test_energy_balance_with_a_controller(ur5):
    model = frictionless(ur5, ROTOR)
    states = integrate(model, pid.random_trajectory(ur5, 2, duration=20.0), step=0.002)
    total = energy(model, states, ROTOR)
    power = (drive(states) * states.v).sum(axis=1)
    work = np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2)]) / states.rate
    assert np.abs(total - total[0] - work).max() < 1e-4 * np.ptp(total)


TWO_LINKS = """<robot name="two_links"><link name="base"/>
<link name="a"><inertial><origin xyz="0.4 0 0"/><mass value="2"/>
 <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="b"><inertial><origin xyz="0.3 0.05 0"/><mass value="1"/>
 <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial></link>
<joint name="one" type="continuous"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/></joint>
<joint name="two" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0.8 0 0"/><axis xyz="0 0 1"/></joint>
</robot>"""


def test_momentum_of_a_free_two_link_arm_is_conserved(tmp_path):
    (tmp_path / "two.urdf").write_text(TWO_LINKS)
    robot = pid.load_robot(tmp_path / "two.urdf", gravity=(0.0, 0.0, 0.0))
    model = pid.Model.nominal(robot, ["rigid_body"])
    b = np.array([[0.0, 0.0], [0.0, 0.0]])
    push = pid.Trajectory(np.array([[0.3, 0.1], [-0.8, 0.5]]), b, np.zeros(2), 0.2, 5.0)  # begins in motion
    states = integrate(model, push, Released())
    body = robot.pinocchio
    data = body.createData()
    # about the first joint's axis nothing pushes: its row of M(q) v is the angular momentum
    momentum = [(pin.crba(body, data, q) @ v)[0] for q, v in zip(states.q, states.v, strict=True)]
    assert np.ptp(states.v[:, 0]) > 0.1  # it is exchanged between the links
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-9)


@pytest.mark.parametrize("step", [0.001, 0.02])
@pytest.mark.parametrize("presliding", [0.0, 1e-3])
def test_friction_never_feeds_energy(ur5, presliding, step):
    coulomb = replace(SMOOTH, presliding=presliding)
    model = arm(ur5, coulomb)
    states = integrate(model, resting(POSE, 3.0), Released(), step=step)
    total = energy(model, states, ROTOR)
    # what bent bristles hold is at most Fc presliding / 2 for each joint, and comes back
    held = (COULOMB * presliding).sum() / 2
    assert total[0] - total[-1] > 10.0
    highest_after = np.maximum.accumulate(total[::-1])[::-1]
    assert (highest_after - total).max() <= held + 1e-6


def test_halving_the_step(ur5):
    model = arm(ur5)
    motion = pid.random_trajectory(ur5, 3, base_frequency=0.5)
    exact = integrate(model, motion, step=0.0005)
    errors = [
        np.abs(integrate(model, motion, step=step).q - exact.q[:: round(step / 0.0005)]).max()
        for step in (0.008, 0.004, 0.002)
    ]
    assert errors[1] < 1e-7
    assert errors[0] > 8 * errors[1] > 64 * errors[2]  # third order at least, dry friction included


def test_stiction_holds_an_arm_under_gravity(ur5):
    strong = np.array([60.0, 60.0, 40.0, 10.0, 10.0, 10.0])  # N m: more than gravity asks
    values = np.concatenate([ur5.nominal, ROTOR, VISCOUS, strong])
    sticking = replace(arm(ur5, CoulombFriction()), theta=values)  # as it is by default
    states = integrate(sticking, resting(POSE, 10.0), Released())
    late = states.time > 5.0
    assert np.abs(states.q - POSE).max() < 2e-3  # bends, and holds
    assert np.abs(states.q[late] - states.q[-1]).max() < 1e-6  # no creep
    assert np.abs(states.v[late]).max() < 1e-5
    assert np.abs(states.a[late]).max() < 1e-2  # no chatter
    # the smooth sign creeps by its nature: tanh(v / smoothing) must carry gravity
    smooth = integrate(replace(arm(ur5), theta=values), resting(POSE, 10.0), Released())
    assert np.abs(smooth.q[late] - smooth.q[-1]).max() > 1e-3


@pytest.mark.parametrize("presliding", [0.0, 1e-4])
def test_a_held_arm_neither_creeps_nor_chatters(ur5, presliding):
    stiff = PD(tuple(1e5 * ROTOR), tuple(1e3 * ROTOR))
    pushed = pid.Model(ur5, arm(ur5).effects, np.concatenate([1.3 * ur5.nominal, ROTOR, VISCOUS, COULOMB]))
    model = replace(pushed, effects=arm(ur5, replace(SMOOTH, presliding=presliding)).effects)
    for controller in (stiff, None):
        states = integrate(model, resting(POSE, 6.0), controller)
        late = states.time > 5.0
        assert np.abs(states.v[late]).max() < 2e-3 * 1e-2
        assert np.abs(states.a[late]).max() < 1e-3
