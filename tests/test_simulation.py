"""Simulated recordings hold the model's torque, and what the simulator must refuse."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.effects.friction import ViscousFriction
from physident.effects.inertia import RigidBody, RotorInertia
from physident.effects.measurement import TorqueOffset
from physident.excitation.motion.point_to_point import PointToPoint
from physident.simulation.controllers import PD, ComputedTorque
from physident.simulation.integrate import integrate
from physident.simulation.plant import Plant
from physident.simulation.sensors import Sensors
from physident.simulation.simulate import Simulation, simulate, simulate_many
from tests.robots import TREE
from tests.simulated_arm import COULOMB, OFFSET, POSE, ROTOR, SMOOTH, VISCOUS, arm, drive, frictionless, resting


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


def test_a_heavy_slide_makes_the_gains_of_a_light_wrist_no_larger_than_a_simulation_can_follow(tmp_path: Path) -> None:
    """A quill's kilograms are no measure of a wrist's kg m^2: damping that undoes a speed twice over in a millisecond shakes the arm."""
    path = tmp_path / "tree.urdf"
    path.write_text(TREE)
    robot = pid.load_robot(path)
    rotors = np.array([500.0, *np.full(robot.n - 1, 1e-4)])  # kg, kg m^2
    heavy = pid.Model(robot, (RigidBody(), RotorInertia()), np.concatenate([robot.nominal, rotors]))
    pose = np.zeros(robot.n)
    gains, inertia = PD.of_bandwidth(heavy, pose, step=1e-3), np.diag(Plant(heavy).inertia(pose))
    assert inertia[0] / inertia[1:].min() > 1000
    assert (1e-3 * np.array(gains.damping) / inertia < 2).all()
    light = pid.Model(robot, heavy.effects, np.concatenate([robot.nominal, [1.0, *rotors[1:]]]))
    np.testing.assert_allclose(PD.of_bandwidth(light, pose, step=1e-3).damping[1:], gains.damping[1:])
