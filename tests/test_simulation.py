"""The simulated arm against an independent engine, conservation laws, and what it must refuse."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.cli import run
from physident.effects.friction import CoulombFriction, ViscousFriction
from physident.effects.measurement import TorqueOffset
from physident.effects.rigid_body import RigidBody, RotorInertia
from physident.excitation.motion.point_to_point import PointToPoint
from physident.simulation.controllers import PD, ComputedTorque, Released
from physident.simulation.integrate import integrate
from physident.simulation.sensors import Sensors
from physident.simulation.simulate import Simulation, simulate, simulate_many
from tests.robots import TREE

ROTOR = np.array([0.9, 0.8, 0.6, 0.2, 0.2, 0.2])  # kg m^2
VISCOUS = np.array([6.0, 6.0, 4.0, 2.0, 2.0, 1.0])  # N m s/rad
COULOMB = np.array([8.0, 8.0, 6.0, 2.0, 2.0, 1.5])  # N m
OFFSET = np.array([0.5, -0.4, 0.3, -0.2, 0.1, 0.2])  # N m
POSE = np.array([0.3, -1.0, 0.8, 0.2, -0.5, 0.1])
SMOOTH = CoulombFriction(smoothing=0.01, presliding=0.0)  # a function of the state, so that a model states its torque


def arm(robot: pid.Robot, coulomb: CoulombFriction = SMOOTH, *others: pid.Effect, theta: tuple = ()) -> pid.Model:
    """A UR5 with rotor inertia, viscous and dry friction, and whatever else."""
    effects = (RigidBody(), RotorInertia(), ViscousFriction(), coulomb, *others)
    return pid.Model(robot, effects, np.concatenate([robot.nominal, ROTOR, VISCOUS, COULOMB, *theta]))


def frictionless(robot: pid.Robot, rotor: np.ndarray) -> pid.Model:
    return pid.Model(robot, (RigidBody(), RotorInertia()), np.concatenate([robot.nominal, rotor]))


def resting(q: np.ndarray, duration: float) -> pid.Trajectory:
    """A motion that stays where it is."""
    none = np.zeros((len(q), 2))
    return pid.Trajectory(none, none, q, 1 / duration, duration)


def energy(model: pid.Model, states: pid.Signals, rotor: np.ndarray) -> np.ndarray:
    body = model.robot.pinocchio
    data = body.createData()
    return np.array(
        [
            pin.computeKineticEnergy(body, data, q, v) + pin.computePotentialEnergy(body, data, q) + rotor @ v**2 / 2
            for q, v in zip(states.q, states.v, strict=True)
        ]
    )


def drive(states: pid.Signals) -> np.ndarray:
    """The drive's torque (N, n)."""
    assert states.torque is not None
    return states.torque


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


def test_recorded_torque_is_the_models(ur5):
    model = arm(ur5, SMOOTH, TorqueOffset(), theta=(OFFSET,))
    motion = pid.random_trajectory(ur5, 5, base_frequency=0.2)
    for controller in (None, ComputedTorque(model=frictionless(ur5, ROTOR))):
        states = integrate(model, motion, controller)
        np.testing.assert_allclose(drive(states), model.torque(states) - OFFSET, atol=1e-5)
        recording = simulate(model, motion, controller)
        np.testing.assert_allclose(recording.effort, model.torque(states)[::2], atol=1e-5)
        np.testing.assert_array_equal(recording.q, states.q[::2])


def test_computed_torque_with_the_true_model_follows_exactly(ur5):
    motion = pid.random_trajectory(ur5, 6, duration=10.0)
    states = integrate(arm(ur5), motion, ComputedTorque())
    np.testing.assert_allclose(states.q, motion.states(states.time).q, atol=1e-9)


def test_identification_returns_the_truth(ur5, tmp_path):
    model = arm(ur5, SMOOTH, TorqueOffset(), theta=(OFFSET,))
    estimate = pid.identify(ur5, [simulate(model, pid.random_trajectory(ur5, 7, duration=20.0))], model.effects)
    for effect, truth in (("viscous_friction", VISCOUS), ("coulomb_friction", COULOMB), ("torque_offset", OFFSET)):
        np.testing.assert_allclose(estimate.model.parameters(effect), truth, atol=0.02)
    # and what was identified is an arm that the command line simulates
    estimate.save(tmp_path / "model.json")
    motion = pid.random_trajectory(ur5, 1, base_frequency=0.4)
    motion.save(tmp_path / "plan.json")
    files = {"--model": "model.json", "--trajectory": "plan.json", "--out": "again.csv"}
    assert (
        run(["simulate", *(str(tmp_path / x) if x in files.values() else x for pair in files.items() for x in pair)])
        == 0
    )
    again, first = pid.load_recording(tmp_path / "again.csv"), simulate(model, motion)
    np.testing.assert_allclose(again.q, first.q, atol=1e-3)
    np.testing.assert_allclose(again.effort, first.effort, atol=0.1)


def test_parameters_of_no_possible_body_simulate_alike(ur5):
    """An estimate may leave a link's mass at zero beside its first moment: the same base parameters, the same motion."""
    # the mass of link 1 turns nothing; the first moment along joint 1's axis neither
    moved = ur5.nominal.copy()
    moved[0] = 0.0
    motion = pid.random_trajectory(ur5, 5, base_frequency=0.2)
    states = [
        integrate(
            pid.Model(ur5, (RigidBody(), RotorInertia()), np.concatenate([links, ROTOR])),
            motion,
            PD.of_bandwidth(arm(ur5), POSE),
        )
        for links in (ur5.nominal, moved)
    ]
    np.testing.assert_allclose(states[0].q, states[1].q, atol=1e-8)
    np.testing.assert_allclose(drive(states[0]), drive(states[1]), atol=1e-6)


@dataclass(frozen=True)
class SquareDrag(pid.Effect):
    """A minimal effect: it says what its column is, and nothing else."""

    name: ClassVar[str] = "square_drag"
    unit: ClassVar[str] = "N m s^2/rad^2"

    def values(self, robot, signals):
        return (signals.v * np.abs(signals.v)).T[self.active(robot)]


@dataclass(frozen=True)
class PoseInertia(pid.Effect):
    """A minimal effect that feels the acceleration, of another joint too."""

    name: ClassVar[str] = "pose_inertia"
    unit: ClassVar[str] = "kg m^2"

    def values(self, robot, signals):
        a = signals.a.T
        return ((2 + np.sin(signals.q.T)) * (a + 0.2 * np.roll(a, 1, axis=0)))[self.active(robot)]


@dataclass(frozen=True)
class LoadFriction(pid.Effect):
    """Friction that grows with the torque of inertia and gravity, which depends on the acceleration sought."""

    name: ClassVar[str] = "load_friction"
    unit: ClassVar[str] = "-"

    def values(self, robot, signals):
        raise AssertionError("a simulation must ask torque_at")

    def torque_at(self, robot, signals, state, load):
        return (np.tanh(signals.v / 0.01) * np.abs(load)).T[self.active(robot)]


def test_minimal_effects_work_in_the_simulator(ur5):
    motion = pid.random_trajectory(ur5, 9, base_frequency=0.2)
    for effect, value in ((SquareDrag(), 3.0), (PoseInertia(joints=(2, 4)), 0.4)):
        model = arm(ur5, SMOOTH, effect, theta=(np.full(len(effect.active(ur5)), value),))
        states = integrate(model, motion)
        np.testing.assert_allclose(drive(states), model.torque(states), atol=1e-5)
        without = integrate(arm(ur5), motion)
        assert np.abs(drive(states) - drive(without)).max() > 0.1


ON_THE_PLANT = [name for name, effect in pid.CATALOGUE.items() if effect.acts_on == "plant" and effect.pointwise]


@pytest.mark.parametrize("name", ON_THE_PLANT)
def test_every_effect_of_the_catalogue_acts_as_its_model_says(ur5, name):
    effect = SMOOTH if name == "coulomb_friction" else pid.CATALOGUE[name].at_grid_middle()
    strength = np.full(len(effect.columns(ur5)), 0.1)
    base = [part for part in (RigidBody(), RotorInertia(), ViscousFriction(), SMOOTH) if part.name != name]
    nominal = pid.Model.nominal(ur5, base)
    model = pid.Model(ur5, (*base, effect), np.concatenate([nominal.theta, strength]))
    if name == "rigid_body":
        model = replace(nominal, effects=(*base, effect), theta=np.concatenate([nominal.theta, 1.1 * ur5.nominal]))
    states = integrate(model, pid.random_trajectory(ur5, 9, base_frequency=0.4))
    np.testing.assert_allclose(drive(states), model.torque(states), atol=2e-5)


def test_friction_may_depend_on_the_load(ur5):
    motion = pid.random_trajectory(ur5, 9, base_frequency=0.2)
    states = integrate(arm(ur5, SMOOTH, LoadFriction(), theta=(np.full(6, 0.1),)), motion)
    plain = arm(ur5)
    load = pid.Model(ur5, plain.effects[:2], plain.theta[:66]).torque(states)
    expected = plain.torque(states) + 0.1 * np.tanh(states.v / 0.01) * np.abs(load)
    np.testing.assert_allclose(drive(states), expected, atol=1e-5)


@dataclass(frozen=True)
class Broken(pid.Effect):
    name: ClassVar[str] = "broken"
    unit: ClassVar[str] = "N m"

    def values(self, robot, signals):
        return np.full((6, len(signals.time)), np.nan)


@dataclass(frozen=True)
class BrokenMeter(Broken):
    name: ClassVar[str] = "broken_meter"
    acts_on: ClassVar = "measurement"


def test_an_effect_that_is_no_number_is_refused(ur5):
    motion = pid.random_trajectory(ur5, 9, base_frequency=0.4)
    for effect, message in ((Broken(), "first state"), (BrokenMeter(), "broken_meter")):
        with pytest.raises(pid.PhysidentError, match=message):
            simulate(arm(ur5, SMOOTH, effect, theta=(np.ones(6),)), motion)


def test_extra_torque_pushes_and_is_not_measured(ur5):
    motion = pid.random_trajectory(ur5, 9, base_frequency=0.2)

    def push(time: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.array([5.0 * np.sin(time), 0, -2.0 * q[2], 0, 0, 1.0])

    states = integrate(arm(ur5), motion, extra_torque=push)
    pushed = np.array([push(*instant) for instant in zip(states.time, states.q, states.v, strict=True)])
    np.testing.assert_allclose(drive(states) + pushed, arm(ur5).torque(states), atol=1e-5)


def test_point_to_point_moves_with_their_corners(ur5):
    points = np.array([POSE, POSE + np.array([0.5, -0.3, 0.4, 0.2, -0.6, 1.0]), POSE])
    motion = PointToPoint(points, speed=0.8, acceleration=2.0)
    for controller in (None, ComputedTorque()):
        states = integrate(arm(ur5), motion, controller)
        np.testing.assert_allclose(drive(states), arm(ur5).torque(states), atol=1e-5)
        assert np.abs(states.q - motion.states(states.time).q).max() < 0.03


def test_gains_of_any_stiffness(ur5):
    motion = pid.random_trajectory(ur5, 9, base_frequency=0.4)
    for stiffness in (1e3, 1e6, 1e9):
        states = integrate(arm(ur5), motion, PD((stiffness,) * 6, (2 * np.sqrt(stiffness),) * 6))
        assert np.abs(states.q - motion.states(states.time).q).max() < 60.0 / stiffness


def test_a_tree_with_a_prismatic_joint(tmp_path):
    (tmp_path / "tree.urdf").write_text(TREE)
    robot = pid.load_robot(tmp_path / "tree.urdf")
    n = robot.n
    effects = (RigidBody(), ViscousFriction(), SMOOTH)
    model = pid.Model(robot, effects, np.concatenate([robot.nominal, np.full(n, 0.5), np.full(n, 0.5)]))
    motion = pid.random_trajectory(robot, 0, base_frequency=0.2, duration=5.0, scale=0.5)
    states = integrate(model, motion)
    np.testing.assert_allclose(drive(states), model.torque(states), atol=1e-6)
    assert np.abs(states.q - motion.states(states.time).q).max() < 0.1


def test_a_seed_is_a_recording_alone_or_in_parallel(ur5):
    noisy = Sensors(torque_noise=1.0, jitter=1e-3)
    motion = pid.random_trajectory(ur5, 9, base_frequency=0.4)
    simulations = [Simulation(arm(ur5), motion, sensors=noisy, seed=seed) for seed in (0, 1, 0)]
    parallel = simulate_many(simulations, processes=2)
    alone = simulate(arm(ur5), motion, sensors=noisy, seed=1)
    assert alone.sha256 == parallel[1].sha256
    assert parallel[0].sha256 == parallel[2].sha256 != parallel[1].sha256


BAD = {
    "beyond limits": (lambda r, m: {"trajectory": pid.Trajectory(3 * m.a, 3 * m.b, m.q0, 0.4, 2.5)}, "joint 1 reaches"),
    "another robot's": (lambda r, m: {"trajectory": resting(np.zeros(4), 3.0)}, "4 joints"),
    "negative gain": (lambda r, m: {"controller": PD((-100.0,) * 6, (1.0,) * 6)}, "negative"),
    "gains that are no numbers": (lambda r, m: {"controller": PD((np.nan,) * 6, (1.0,) * 6)}, "finite"),
    "gains of another robot": (lambda r, m: {"controller": PD((100.0,) * 4, (1.0,) * 4)}, "expected 6"),
    "gains too soft": (
        lambda r, m: {"controller": PD((0.1,) * 6, (0.0,) * 6), "extra_torque": lambda t, q, v: 60 + 0 * q},
        "away from the motion",
    ),
    "pushed out of control": (lambda r, m: {"extra_torque": lambda t, q, v: 9e3 * v + 1}, "too steeply"),
    "beyond the drives": (lambda r, m: {"extra_torque": lambda t, q, v: 200 * np.eye(6)[0]}, "its drive gives 150"),
    "extra torque of wrong size": (lambda r, m: {"extra_torque": lambda t, q, v: np.zeros(3)}, "expected 6"),
    "extra torque not finite": (lambda r, m: {"extra_torque": lambda t, q, v: np.full(6, np.nan)}, "finite"),
    "step too large": (lambda r, m: {"step": 0.05}, "too large"),
    "step of nothing": (lambda r, m: {"step": 0.0}, "not positive"),
    "no body": (lambda r, m: {"model": pid.Model(r, (RigidBody(),), -r.nominal)}, "not positive"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_named(ur5, case):
    make, message = BAD[case]
    motion = pid.random_trajectory(ur5, 0, base_frequency=0.4)
    with pytest.raises(pid.PhysidentError, match=message) as caught:
        simulate(**{"model": arm(ur5), "trajectory": motion, **make(ur5, motion)})
    assert "\n" not in str(caught.value)


def test_command_line(ur5, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    motion = pid.random_trajectory(ur5, 0, base_frequency=0.4)
    motion.save("plan.json")
    assert run(["simulate", "--robot", "ur5", "--trajectory", "plan.json", "--out", "rec.csv"]) == 0
    recording = pid.load_recording("rec.csv")
    assert recording.n == 6
    assert recording.duration == pytest.approx(2.5, abs=0.008)
    np.testing.assert_allclose(recording.effort, simulate(pid.Model.nominal(ur5), motion).effort, rtol=1e-8, atol=1e-8)
    replace(motion, a=9 * motion.a, b=9 * motion.b).save("wild.json")
    (tmp_path / "sensors.json").write_text('{"schema": "physident.sensors/1", "rate": -5}')
    for line, text in (
        ("--robot ur5 --trajectory wild.json", "joint 1"),
        ("--robot ur5 --trajectory none.json", "none.json"),
        ("--trajectory plan.json", "--model"),
        ("--robot ur5 --trajectory plan.json --controller magic", "magic"),
        ("--robot ur5 --trajectory plan.json --sensors sensors.json", "rate"),
    ):
        capsys.readouterr()
        assert run(f"simulate {line} --out bad.csv".split()) == 2
        error = capsys.readouterr().err
        assert text in error
        assert error.count("\n") == 1
    assert sorted(file.name for file in tmp_path.iterdir()) == ["plan.json", "rec.csv", "sensors.json", "wild.json"]
