"""Slow motions of an arm whose friction grows with load: what the description lacks is no delay between the channels."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.setup_checks.check_setup import check_setup
from tests.plant import Arm, Drives, Ripple, Sensors, hide, multisine, record
from tests.plant.laws import Bristle
from tests.serial_arms import ARMS, urdf

pytestmark = pytest.mark.slow

RUBS, OIL = 0.5, 1.0  # N m, N m s/rad
PER_LOAD, GROWS = 0.4, 0.85  # N m of friction for a N m that a joint carries, and the power by which it grows with that


def recorded(seed: int, late: float = 0.0) -> pid.Recording:
    """Two joints that move from pose to pose; rigid torque by pinocchio, the efforts ``late`` [s] on the clock of the positions."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 30.0, 0.008)
    model = pin.buildModelFromXML(urdf(ARMS["two"]))
    poses, lasts = rng.uniform(-1.5, 1.5, (11, 2)), 3.0

    def motion(t: np.ndarray) -> np.ndarray:
        """Positions, velocities and accelerations (3, N, 2) of steps by a polynomial of degree five that last 2 s, with a second of rest."""
        k = np.clip((t / lasts).astype(int), 0, 9)
        u = np.clip((t - k * lasts) / 2.0, 0.0, 1.0)[:, None]
        parts = (10 * u**3 - 15 * u**4 + 6 * u**5, 15 * (u - u**2) ** 2, 15 * (u - u**2) * (1 - 2 * u))
        return np.array(
            [parts[0] * (poses[k + 1] - poses[k]) + poses[k], *(p * (poses[k + 1] - poses[k]) for p in parts[1:])]
        )

    q, v, a = motion(time - late)
    data = model.createData()
    tau = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
    tau += (RUBS + PER_LOAD * np.abs(tau) ** GROWS) * np.clip(v / 0.005, -1, 1) + OIL * v
    tau += 0.02 * rng.standard_normal(tau.shape)
    q, v, _ = motion(time)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"{seed}")


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    path = tmp_path_factory.mktemp("delay") / "two.urdf"
    path.write_text(urdf(ARMS["two"]))
    return pid.load_robot(path)


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_friction_that_a_description_lacks_is_no_delay(robot: pid.Robot, seed: int) -> None:
    assert [finding.kind for finding in check_setup(robot, [recorded(seed)])] == []


@pytest.mark.parametrize("late", [-0.1, 0.1])
def test_a_delay_of_slow_motions_is_seen_all_the_same(robot: pid.Robot, late: float) -> None:
    (found,) = check_setup(robot, [recorded(seed, late) for seed in (1, 2, 3, 4)])
    assert found.kind == "effort_delay"
    assert ("later" if late > 0 else "earlier") in found.statement


@pytest.mark.parametrize("late", [0.0, 0.015, 0.04])
def test_the_lag_of_bristles_is_no_part_of_a_delay(ur5: pid.Robot, tmp_path: Path, late: float) -> None:
    """Friction of LuGre's kind, which lets go beyond its sliding friction, comes late after each reversal, on the wrist's joints most."""
    friction, level = Arm().friction, Arm().friction.coulomb
    law = Bristle(stiffness=level / 0.003, damping=0.1 * np.sqrt(level / 0.003), fade=np.full(6, 0.1))
    arm = replace(Arm(), friction=replace(friction, law=law, onset=0.3 * level))
    runs = []
    for seed in (101, 102, 103):
        made = record(hide(arm, "time_delay", (), late), multisine(seed, duration=30.0), Sensors(), seed, step=2e-3)
        made.write_csv(tmp_path / f"{seed}.csv")
        runs.append(pid.load_recording(tmp_path / f"{seed}.csv"))
    found = [finding for finding in check_setup(ur5, runs) if finding.kind == "effort_delay"]
    assert len(found) == (late > 0.02)
    for finding in found:
        low, high = (int(x) for x in re.findall(r"\d+", finding.evidence))
        assert low <= 1e3 * late <= high
        assert high - low < 10


@pytest.mark.parametrize(("seed", "joint"), [(3, 4), (4, 6), (6, 6)])
def test_the_ripple_of_one_motor_is_no_delay(ur5: pid.Robot, tmp_path: Path, seed: int, joint: int) -> None:
    """A joint whose torque is mostly ripple is explained best with some shift, whatever the clocks: no other joint asks for it."""
    arm = replace(Arm(), drives=Drives(ripples=(Ripple(joint - 1, 2.5, 505.0, 0.7),)))
    record(arm, multisine(seed, speed=0.3), Sensors(), seed, step=2e-3).write_csv(tmp_path / "slow.csv")
    recording = pid.load_recording(tmp_path / "slow.csv")
    assert "effort_delay" not in [finding.kind for finding in check_setup(ur5, [recording])]
