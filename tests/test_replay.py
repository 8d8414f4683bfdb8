"""A simulated arm follows the recorded one as far as its model is right, in both simulators, from measured states."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.diagnosis.result.saved import read_diagnosis
from physident.effects.hysteresis import PreslidingHysteresis
from physident.effects.inertia import Payload
from physident.effects.learned.curves import LearnedTorque
from physident.estimation.estimate import Estimate, as_estimate
from physident.recordings.formats.csv import write_csv
from physident.replay.replay import replay
from physident.replay.score import Replay
from physident.replay.windows import cut_windows, drive_torque
from physident.simulation.integrate import integrate
from physident.simulation.simulate import Simulation
from tests.serial_arms import ARMS, urdf

pytestmark = pytest.mark.slow

NAMES = ("rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction", "torque_offset")
SIMULATORS = ("mujoco", "physident")
SHORT, LONG = 5.0, 10.0  # s: a replay from every state takes as long as there are states


def arm(*more: pid.Effect, extra: tuple[float, ...] = ()) -> pid.Model:
    """A UR5 with friction, a torque offset, and more effects with their parameters."""
    robot = pid.load_robot("ur5")
    effects = (*pid.make_effects(NAMES), *more)
    theta = np.concatenate([
        robot.nominal, [2.0, 2.0, 1.0, 0.4, 0.4, 0.4], [12.0, 12.0, 8.0, 2.0, 2.0, 2.0],
        [6.0, 6.0, 4.0, 1.0, 1.0, 1.0], [1.0, -2.0, 0.5, 0.0, 0.3, 0.0], extra,
    ])  # fmt: skip
    return pid.Model(robot, effects, theta)


def recorded(model: pid.Model, duration: float = SHORT) -> pid.Recording:
    """A simulated arm on one period of a random motion of some duration [s]."""
    motion = pid.random_trajectory(model.robot, seed=1, duration=duration, base_frequency=1 / duration)
    return pid.simulate(model, motion)


def estimate_of(model: pid.Model) -> Estimate:
    return as_estimate(model, pid.Filter())


@pytest.fixture(scope="module")
def recording() -> pid.Recording:
    return recorded(arm())


@pytest.fixture(scope="module")
def long_recording() -> pid.Recording:
    return recorded(arm(), LONG)


@pytest.fixture(scope="module")
def followed(recording: pid.Recording) -> Replay:
    """The true model's replay over a fifth of a second."""
    return replay(estimate_of(arm()), None, [recording], "physident", 0.2).replay


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_the_true_model_follows_its_recording(long_recording: pid.Recording, simulator: str) -> None:
    """Within 2 % of each joint's range over a second, under the recorded torque, which is sampled at 125 Hz."""
    result = replay(estimate_of(arm()), None, [long_recording], simulator, 1.0).replay  # pyright: ignore[reportArgumentType]
    moved = np.ptp(long_recording.q, axis=0)
    assert (result.before.position < 0.02 * moved).all()
    assert result.before.lost == 0.0
    # MuJoCo's dry friction is a step at zero velocity, the model's is smooth over 0.01 rad/s
    share = {"mujoco": 0.05, "physident": 0.01}[simulator]
    assert (result.before.torque < share * np.abs(long_recording.effort).max(axis=0)).all()
    assert result.starts > 100


def test_both_simulators_agree_with_the_integrator_under_the_same_torque() -> None:
    """With dry friction and hysteresis, from states in motion, against another integration scheme."""
    model = arm(PreslidingHysteresis((2, 5), (0.02, 0.01)), extra=(4.0 / 0.02, 1.0 / 0.01))
    truth = integrate(
        model, pid.random_trajectory(model.robot, seed=2, duration=SHORT, base_frequency=1 / SHORT), step=0.002
    )
    moved = np.ptp(truth.q, axis=0)
    assert truth.torque is not None
    recording = pid.Recording(
        truth.time, truth.q, truth.torque + model.parameters("torque_offset"), "torque", dq=truth.v
    )
    own = replay(estimate_of(model), None, [recording], "physident", 1.0).replay
    other = replay(estimate_of(model), None, [recording], "mujoco", 1.0).replay
    assert (own.before.position < 0.02 * moved).all()
    assert own.before.tool < 0.5 * other.before.tool  # MJCF holds the hysteresis only as Coulomb friction
    assert any("presliding_hysteresis" in text for text in other.before.stated)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_a_missing_load_shows_and_is_gone_after_the_diagnosis(recording: pid.Recording, simulator: str) -> None:
    loaded = arm(*pid.make_effects(["payload"]), extra=(2.0, 0.0, 0.0, 0.2, 0.05, 0.0, 0.05, 0.0, 0.0, 0.02))
    result = replay(estimate_of(arm()), estimate_of(loaded), [recorded(loaded)], simulator).replay  # pyright: ignore[reportArgumentType]
    assert result.after is not None
    assert result.before.tool > 0.02
    assert result.after.tool < 0.1 * result.before.tool
    assert (result.after.torque[1:3] < 0.3 * result.before.torque[1:3]).all()
    assert f"{1e3 * result.before.tool:.3g} mm -> {1e3 * result.after.tool:.3g} mm at the tool" in repr(result)


def test_effects_of_the_measurement_are_removed_from_the_torque(followed: Replay) -> None:
    """A wrong torque constant and encoder zeros move no arm: with them in the model, the replay is as good as without."""
    more = pid.make_effects(["torque_constant", "joint_zero_offset"])
    extra = (0.0, 0.0, 0.0, 0.2, 0.0, -0.1, 0.0, 0.03, -0.02, 0.01, 0.02, 0.0)
    wrong = arm(*more, extra=extra)
    result = replay(estimate_of(wrong), estimate_of(arm()), [recorded(wrong)], "physident", 0.2).replay
    right = followed.before
    assert result.after is not None
    assert result.before.tool < 2 * right.tool
    assert result.before.tool_following < 2 * right.tool_following
    assert result.after.tool > 10 * right.tool


def test_the_drives_torque_solves_the_measurement() -> None:
    model = arm(*pid.make_effects(["torque_constant"]), extra=(0.3, -0.2, 0.1, 0.0, 0.0, 0.5))
    signals = pid.prepare(recorded(model), pid.Filter())
    windows = cut_windows([signals], 0.5, 0.5)
    drive = drive_torque(model, windows)
    again = drive * (1 + model.parameters("torque_constant")) + model.parameters("torque_offset")
    np.testing.assert_allclose(again, windows.torque, atol=1e-6)


def bent(shown: Callable[[np.ndarray], np.ndarray], most: float) -> pid.Model:
    """The arm whose channel of joint 2 shows a function of the drive's torque, up to ``most`` [N m], as a learned curve holds it."""
    curve = LearnedTorque((2,), low=(-most,), high=(most,), amplitude=(most,))
    x = np.linspace(-most, most, 500)
    modes = curve.shapes_at(pid.load_robot("ur5"), x)
    return arm(curve, extra=tuple(np.linalg.lstsq(modes, shown(x) - x, rcond=None)[0]))


def test_a_channel_that_shows_several_times_the_torque_is_undone() -> None:
    """Of iron that saturates: the current grows by several times of what the torque does, and is still one for each torque."""
    model = bent(lambda tau: tau * (1 + np.abs(tau / 30) ** 4) ** 0.25, 120.0)
    plain = arm()
    signals = pid.prepare(recorded(plain), pid.Filter())
    assert signals.torque is not None
    true = signals.torque - plain.parameters("torque_offset")
    x = np.linspace(-200, 200, 100001)
    curve, theta = next((e, theta) for e, theta in model.effect_parameters() if e.name == "learned_torque")
    assert isinstance(curve, LearnedTorque)
    shown = x + curve.shapes_at(plain.robot, x) @ theta
    assert np.diff(shown).min() > 0
    assert np.gradient(shown, x).max() > 4
    measured = signals.torque.copy()
    measured[:, 1] = np.interp(true[:, 1], x, shown) + plain.parameters("torque_offset")[1]
    windows = cut_windows([replace(signals, torque=measured)], 0.5, 0.5)
    right = cut_windows([replace(signals, torque=true)], 0.5, 0.5)
    np.testing.assert_allclose(drive_torque(model, windows), right.torque, atol=0.05)


def test_a_dead_band_is_told() -> None:
    """No torque inside it can be told from another one."""
    model = bent(lambda tau: tau - np.clip(tau, -20, 20), 120.0)
    signals = pid.prepare(recorded(arm()), pid.Filter())
    assert signals.torque is not None
    near = replace(signals, torque=0.2 * signals.torque)
    with pytest.warns(pid.PhysidentWarning, match=r"does not tell the torque of the drive.*joint 2 for"):
        drive_torque(model, cut_windows([near], 0.5, 0.5))


def test_windows_stay_inside_the_motion_and_beside_the_gaps(recording: pid.Recording) -> None:
    signals = pid.prepare(recording, pid.Filter())
    half = len(signals.time) // 2
    late = signals.time + np.where(np.arange(len(signals.time)) >= half, 0.5, 0.0)
    broken = replace(signals, time=late, starts=(0, half))
    windows = cut_windows([broken], 0.5, 0.05)
    for w, start in enumerate(windows.start):
        k = int(np.argmin(np.abs(late - start)))
        assert not k < half <= k + round(0.5 * signals.rate)
        np.testing.assert_allclose(windows.q[w, 0], signals.q[k])
    with pytest.raises(pid.InputError, match=r"without a gap for 9.9 s; expected longer recordings"):
        cut_windows([broken], 9.9, 0.05)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"simulator": "bullet"}, "expected mujoco or physident"),
        ({"horizon": 0.0}, "expected 0.02 to 10 s"),
        ({"horizon": float("nan")}, "expected 0.02 to 10 s"),
        ({"recordings": []}, "no recordings given"),
    ],
)
def test_bad_settings_are_refused(recording: pid.Recording, change: dict, message: str) -> None:
    settings = {"recordings": [recording], "simulator": "physident", "horizon": 0.5} | change
    with pytest.raises(pid.InputError, match=message):
        replay(estimate_of(arm()), None, **settings)


def test_a_link_that_cannot_be_is_refused_by_mujoco_alone(recording: pid.Recording, followed: Replay) -> None:
    model = arm()
    theta = model.theta.copy()
    theta[0] = -1.0  # no torque depends on the mass of an upright first link
    broken = estimate_of(replace(model, theta=theta))
    with pytest.raises(pid.InputError, match=r"link 1 .*mass -1 kg.*--simulator physident"):
        replay(broken, None, [recording], "mujoco")
    same = replay(broken, None, [recording], "physident", 0.2).replay
    assert same.before.tool == pytest.approx(followed.before.tool, rel=1e-3)


def test_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.urdf").write_text(urdf(ARMS["two"]))
    plain = pid.Model.nominal(pid.load_robot("two.urdf"), NAMES)
    values = {"rotor_inertia": 1.0, "viscous_friction": 4.0, "coulomb_friction": 3.0, "torque_offset": 0.5}
    theta = np.array([values.get(c.effect or "", t) for c, t in zip(plain.columns, plain.theta, strict=True)])
    healthy = replace(plain, theta=theta)
    load = (3.0, 0.0, 0.0, 0.3, 0.03, 0.0, 0.03, 0.0, 0.0, 0.01)
    loaded = pid.Model(plain.robot, (*plain.effects, Payload()), np.append(theta, load))
    for seed, (name, one) in enumerate({"fitted": healthy, "other": healthy, "now": loaded}.items()):
        motion = pid.random_trajectory(one.robot, seed=seed, duration=10.0)
        write_csv(f"{name}.csv", Simulation(one, motion, sensors=pid.Sensors(torque_noise=0.5), seed=seed).table())
    assert run(["identify", "fitted.csv", "--robot", "two.urdf", "--method", "physical", "--out", "a.json"]) == 0
    capsys.readouterr()
    outputs = ["--json", "r.json", "--plot", "r.png", "--out", "r.rrd"]
    models = ["--model", "a.json", "--model", "a.json"]
    assert run(["replay", *models, "other.csv", *outputs, "--simulator", "mujoco"]) == 0
    shown = capsys.readouterr().out
    data = json.loads(Path("r.json").read_text())
    assert data["verdict"] in shown
    assert data["before"]["tool"] == data["after"]["tool"]
    assert all(Path(name).stat().st_size > 1000 for name in ("r.json", "r.png", "r.rrd"))
    for options in (
        ["--model", "a.json", "fitted.csv"],
        ["--model", "a.json", "other.csv", "--simulator", "bullet"],
        ["--model", "a.json", "other.csv", "--out", "r.txt"],
        ["--model", "a.json", "other.csv", "--meshes", "none"],
        [*models, "--model", "a.json", "other.csv"],
    ):
        assert run(["replay", *options]) == 2, options
        assert len(capsys.readouterr().err.strip().splitlines()) == 1
    diagnosed = ["diagnose", "--model", "a.json", "now.csv", "--json", "d.json"]
    assert run([*diagnosed, "--simulator", "bullet"]) == 2
    assert run([*diagnosed, "--simulator", "physident"]) == 0  # a diagnosis may leave links that MuJoCo refuses
    saved = read_diagnosis("d.json")
    assert saved.simulated is not None
    assert "0.5 s ahead:" in capsys.readouterr().out
    assert run(["report", "--diagnosis", "d.json", "--out", "d.html"]) == 0
    assert "0.5 s ahead:" in Path("d.html").read_text()
