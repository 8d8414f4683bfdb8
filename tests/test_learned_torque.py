"""What a drive or a sensor makes of its torque is learned as a curve over the torque, and a gain stays a gain."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

import physident as pid
from physident.effects.learned.curves import LearnedTorque
from tests.serial_arms import ARMS, urdf
from tests.sines import sines

pytestmark = pytest.mark.slow

Array = NDArray[np.float64]
DRY, DRAG = np.array([1.5, 0.8]), np.array([1.0, 0.5])  # N m, N m s/rad
JOINT, BAND, MOST = 1, 1.2, 16.0  # N m: of the shoulder, that the sensor does not show, and at which the iron saturates
GAIN = 1.08
END = 10.0  # N m, at which a sensor's range ends


def dead_band(tau: Array) -> Array:
    return tau - np.clip(tau, -BAND, BAND)


def saturated(tau: Array) -> Array:
    """The torque that a current stands for, where the motor gives ``tau``."""
    return tau * (1 + np.abs(tau / MOST) ** 4) ** 0.25


def clipped(tau: Array) -> Array:
    """What a sensor shows whose range ends far below the largest torque."""
    return np.clip(tau, -END, END)


def scaled(tau: Array) -> Array:
    return GAIN * tau


def recorded(
    seed: int,
    shown: Callable[[Array], Array] | None = None,
    more: float = 1.0,
    by_load: float = 0.0,
    day: int = 1,
) -> pid.Recording:
    """Two joints with parallel axes along random motions, rigid torque by pinocchio: the shoulder's channel is what it has ``shown`` of its
    torque, its friction is ``more`` than before, and grows ``by_load``; each ``day`` has noise of its own."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 30.0, 0.004)
    model = pin.buildModelFromXML(urdf(ARMS["two"]))
    q, v, a = sines(rng, time, 4, 2, (0.5, 2.5), 0.3)
    data = model.createData()
    tau = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
    load = tau[:, JOINT - 1].copy()
    tau += np.array([more, 1.0]) * (DRY * v / np.sqrt(v**2 + 0.01**2) + DRAG * v)
    tau[:, JOINT - 1] += by_load * np.abs(load) * v[:, JOINT - 1] / np.sqrt(v[:, JOINT - 1] ** 2 + 0.01**2)
    if shown is not None:
        tau[:, JOINT - 1] = shown(tau[:, JOINT - 1])
    tau += 0.05 * np.random.default_rng([seed, day]).standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"{seed} of day {day}")


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    path: Path = tmp_path_factory.mktemp("arm") / "two.urdf"
    path.write_text(urdf(ARMS["two"]))
    return pid.load_robot(path)


@pytest.fixture(scope="module")
def healthy(robot: pid.Robot) -> pid.Estimate:
    return pid.identify(robot, [recorded(seed) for seed in (1, 2, 3)])


@pytest.mark.parametrize("shown", [dead_band, saturated])
@pytest.mark.parametrize("question", ["different", "missing"])
def test_what_a_channel_makes_of_its_torque_is_a_curve_over_the_torque(
    robot: pid.Robot, healthy: pid.Estimate, shown: Callable[[Array], Array], question: str
) -> None:
    runs = [recorded(seed, shown) for seed in (4, 5, 6)]
    found = pid.diagnose_motion(healthy if question == "different" else pid.identify(robot, runs), runs)
    (cause,) = found.causes
    assert (cause.effect, cause.joints) == ("learned_torque", (JOINT,))
    (curve,) = cause.curves
    x = np.array(curve.x)
    if question == "different":  # a model that was fitted to them may hold a line of the curve, as heavier links
        true = shown(x) - x
        assert np.sqrt(np.mean((np.array(curve.torque) - true) ** 2)) < 0.15 * np.ptp(true)


@pytest.mark.parametrize("question", ["again", "different"])
def test_a_gain_is_no_curve(healthy: pid.Estimate, question: str) -> None:
    seeds = (1, 2) if question == "again" else (4, 5)
    (cause,) = pid.diagnose_motion(healthy, [recorded(seed, scaled, day=2) for seed in seeds]).causes
    assert (cause.effect, cause.joints) == ("torque_constant", (JOINT,))
    (gain,) = cause.parameters
    assert gain.value == pytest.approx(GAIN - 1, rel=0.1)


def test_a_gain_and_friction_by_load_are_no_curve(healthy: pid.Estimate) -> None:
    """A bend of the torque is imitated by the two together, and they are not imitated by a bend."""
    causes = pid.diagnose_motion(healthy, [recorded(seed, scaled, by_load=0.08) for seed in (4, 5)]).causes
    assert {(f.effect, f.joints) for f in causes} == {
        ("torque_constant", (JOINT,)),
        ("load_dependent_friction", (JOINT,)),
    }


def test_friction_is_no_curve_over_the_torque(healthy: pid.Estimate) -> None:
    """The torque of a drive holds its friction: along any motion more friction is also a curve over the torque, of a kind."""
    found = pid.diagnose_motion(healthy, [recorded(seed, more=1.6) for seed in (4, 5)])
    assert {(f.effect, f.joints) for f in found.causes} <= {
        ("coulomb_friction", (JOINT,)),
        ("viscous_friction", (JOINT,)),
    }
    assert found.causes


def test_a_healthy_arm_has_none(healthy: pid.Estimate) -> None:
    assert not pid.diagnose_motion(healthy, [recorded(seed) for seed in (4, 5)]).causes


def test_a_curve_reaches_as_far_as_the_torque_that_a_sensor_does_not_show(robot: pid.Robot) -> None:
    """The measured torque ends where the sensor's range does; that of the drive, of which it is a function, goes on."""
    runs, held = [recorded(seed, clipped) for seed in (1, 2, 3)], recorded(4, clipped)
    true = np.abs(np.concatenate([recorded(seed).effort[:, JOINT - 1] for seed in (1, 2, 3)])).max()
    assert true > 1.3 * END
    default = pid.identify(robot, runs).model.effects
    open_range, shown_range = LearnedTorque((JOINT,)), LearnedTorque((JOINT,), low=(-END,), high=(END,))
    whole, short = (pid.identify(robot, runs, effects=[*default, curve]) for curve in (open_range, shown_range))
    low, high = next(e for e in whole.model.effects if isinstance(e, LearnedTorque)).ends(robot)
    assert max(-low, high) == pytest.approx(true, rel=0.1)
    assert pid.validate(whole, held).rms[JOINT - 1] < 0.6 * pid.validate(short, held).rms[JOINT - 1]
