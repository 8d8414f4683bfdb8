"""Friction that builds up over a third of a milliradian: an arm of four joints, by pinocchio, whose joints drag springs that slip."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from tests.serial_arms import Joint, swinging, urdf

pytestmark = pytest.mark.slow

JOINTS = (
    Joint("0 0 1", mass=8.0, length=0.25), Joint("0 1 0", "0 0 0.15", mass=9.0, length=0.45),
    Joint("0 1 0", "0 0 0.45", mass=6.0, length=0.4), Joint("1 0 0", "0 0 0.4", mass=2.5, length=0.12),
)  # fmt: skip
LEVEL, VISCOUS = np.array([6.0, 8.0, 5.0, 1.5]), np.array([8.0, 10.0, 5.0, 1.2])  # N m, N m s/rad
ROTOR, NOISE = np.array([1.2, 1.5, 0.8, 0.15]), np.array([0.3, 0.3, 0.3, 0.09])  # kg m^2, N m
PACE = (0.1 * np.pi, np.pi)  # rad/s
SLIP, HUMP, AT = 0.0003, 9.0, 0.4  # rad, N m, rad/s


def run(number: int, breakaway: float = 0.0, hump: float = 0.0) -> pid.Recording:
    """Twenty seconds; friction that has built up is larger by a share ``breakaway`` at rest, that of joint 2 by a ``hump`` [N m] about a speed."""
    rng, time = np.random.default_rng(number), np.arange(0.0, 20.0, 0.004)
    q, v, tau = swinging(rng, time, JOINTS, 0.25, PACE, ROTOR)
    stretch, stretched = np.zeros(4), []
    for step in np.diff(q, axis=0, prepend=q[:1]):
        stretch = np.clip(stretch + step, -SLIP, SLIP)
        stretched.append(stretch / SLIP)
    tau += VISCOUS * v + LEVEL * np.array(stretched) * (1 + breakaway / (1 + (v / 0.05) ** 2))
    tau[:, 1] += hump * np.sign(v[:, 1]) / (1 + ((np.abs(v[:, 1]) - AT) / 0.1) ** 4)
    tau += NOISE * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=str(number))


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    file = tmp_path_factory.mktemp("arm") / "arm.urdf"
    file.write_text(urdf(JOINTS))
    return pid.load_robot(file)


def leaves(found: pid.Diagnosis) -> np.ndarray:
    """The RMS of left-out rows (4,) in units of what the filter passes of the torque's noise."""
    return np.asarray(found.after.rms) / (NOISE * np.sqrt(2 * found.filter.cutoff * 0.004))


@pytest.mark.parametrize(("number", "breakaway"), [(1, 0.35), (1, 0.0), (2, 0.35)])
def test_a_description_without_friction_lacks_no_delay(robot: pid.Robot, number: int, breakaway: float) -> None:
    """At a reversal a bristle lags by as many milliseconds as a late channel would, but nothing else of the torque does."""
    found = pid.diagnose_motion(pid.Model.described(robot), [run(number, breakaway)])
    told = {f.effect: f for f in found.findings if f.grade != "hint"}
    assert "time_delay" not in told, repr(found)
    assert told["presliding_hysteresis"].joints == (1, 2, 3, 4)
    assert told["presliding_hysteresis"].grade == "cause"
    assert [p.value for p in told["rotor_inertia"].parameters] == pytest.approx(ROTOR, rel=0.03)
    assert leaves(found).max() < 2
    for cause in found.causes:  # a description without it has no Coulomb friction to lose
        assert cause.effect != "coulomb_friction" or max(p.value for p in cause.parameters) > 0, repr(found)


def test_a_delay_beside_bristles_is_found(robot: pid.Robot) -> None:
    late = run(1, 0.35)
    effort = [np.interp(late.time - 0.02, late.time, one) for one in late.effort.T]
    found = pid.diagnose_motion(pid.Model.described(robot), [replace(late, effort=np.column_stack(effort))])
    (delay,) = (f for f in found.causes if f.effect == "time_delay")
    assert delay.parameters[0].interval95[0] < 0.02 < delay.parameters[0].interval95[1]


def test_bristles_show_beside_the_hump_that_hides_them(robot: pid.Robot) -> None:
    """A model is fitted to recordings of the hump: what its friction lacks is the hump, where it is, and the distance on every joint."""
    runs = [run(number, hump=HUMP) for number in (3, 4, 5)]
    found = pid.diagnose_motion(pid.identify(robot, runs), runs)
    told = {f.effect: f for f in found.causes}
    assert 2 in told["learned_velocity"].joints, repr(found)
    assert told["presliding_hysteresis"].joints == (1, 2, 3, 4)
    (curve,) = (one for one in told["learned_velocity"].curves if one.joint == 2)
    x, torque = np.array(curve.x), np.array(curve.torque) * np.sign(curve.x)
    top = np.abs(x[np.argmax(np.where(np.abs(x) > 0.1, torque, -np.inf))])
    assert top == pytest.approx(AT, abs=0.1)
    assert np.delete(leaves(found), 1).max() < 2
    assert found.after.rms[1] < HUMP / 15  # its flanks are steeper than a smooth curve
