"""The plant in MuJoCo: its physics against pinocchio and closed forms that know nothing of its integrator."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from tests.plant_mujoco.expected import (
    KINDS,
    PLANT,
    Rising,
    load_of,
    model_of,
    simulated,
    sliding,
    steady_friction,
    still,
)
from tests.plant_mujoco.samples import Kind, sample, sines
from tests.truth import Disturbance, HiddenEffect

Array = NDArray[np.float64]


@pytest.mark.parametrize("name", ["planar", "scara", "seven"])
def test_without_friction_the_torque_is_that_of_inertia_and_gravity(name: str) -> None:
    arm, run = simulated(name, "smooth", 2.0, strength=0.0)
    np.testing.assert_allclose(run.torque, load_of(arm, run), atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_positions_velocities_and_accelerations_belong_together(kind: Kind) -> None:
    arm, run = simulated("seven", kind, 3.0)
    np.testing.assert_allclose(CubicSpline(run.time, run.q)(run.time, 1)[5:-5], run.v[5:-5], atol=2e-3)
    np.testing.assert_allclose(run.v[0] + np.cumsum(run.a, axis=0)[:-1] * 5e-4, run.v[1:], atol=2e-2)
    np.testing.assert_allclose(run.q, sines(arm.joints, 3.0).states(run.time)[0], atol=2e-2)


@pytest.mark.parametrize("name", ["planar", "scara", "seven"])
def test_the_motors_work_becomes_energy_and_heat(name: str) -> None:
    arm, run = simulated(name, "dry")
    model, step = model_of(arm), run.time[1]
    data = model.createData()

    def energy(k: int) -> float:
        moving = 0.5 * float(np.sum(arm.rotor_inertia * run.v[k] ** 2))
        height = pin.computePotentialEnergy(model, data, run.q[k])
        return moving + height + pin.computeKineticEnergy(model, data, run.q[k], run.v[k])

    work = float(np.sum(run.torque * run.v)) * step
    heat = float(np.sum(steady_friction(arm, run.v) * run.v)) * step
    assert heat > 0
    assert work - heat == pytest.approx(energy(-1) - energy(0), abs=1e-3 * heat)


def test_a_stuck_joint_does_not_creep() -> None:
    push = HiddenEffect(
        effect="contact", joints=(), size=8.0, shape={"start": 0.5, "end": 9.5, "direction": (1.0, 0, 0)}
    )
    run = PLANT.simulate(sample(effects=(push,)), still(2, 10.0))
    assert run.at_rest is not None
    assert run.at_rest.all()
    assert np.ptp(run.q, axis=0).max() < 1e-7


def test_a_joint_breaks_away_at_the_stated_torque() -> None:
    arm = sample(disturbances=(Rising(4.0),))
    run = PLANT.simulate(arm, still(2, 3.0))
    began = run.time[np.argmax(np.abs(run.v[:, 0]) > 1e-6)]
    assert 4.0 * began == pytest.approx(arm.friction.breakaway[0], abs=4.0 * 2e-3)


def test_dry_friction_opposes_every_motion() -> None:
    arm, run = simulated("seven", "dry")
    moving = sliding(run)
    opposing = (run.torque - load_of(arm, run)) * run.v
    assert opposing[moving].min() > 0
    slid = np.where(moving, run.torque - load_of(arm, run) - steady_friction(arm, run.v), 0.0)
    assert np.sqrt(np.mean(slid**2)) < 2e-3
    assert run.at_rest is not None
    held = np.abs(run.torque - load_of(arm, run))[run.at_rest[:, 0], 0]
    assert held.max() < arm.friction.breakaway[0] + 1e-2


def test_bristles_never_give_more_work_than_they_store() -> None:
    arm, run = simulated("seven", "bristle")
    f = arm.friction
    force = run.torque - load_of(arm, run) - f.viscous * run.v
    work = np.cumsum(force * run.v, axis=0) * run.time[1]
    assert work.min() > -1e-6
    assert np.abs(force).max(axis=0) == pytest.approx(f.breakaway, rel=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["planar", "scara", "seven"])
def test_torque_along_the_plants_own_motion_is_what_it_reported(name: str, kind: Kind) -> None:
    arm, run = simulated(name, kind)
    along = PLANT.torque_along(arm, run)
    moving = sliding(run)
    assert np.isfinite(along[moving]).all()
    assert np.sqrt(np.mean((along - run.torque)[moving] ** 2)) < 2e-3
    if run.at_rest is not None:
        assert np.isnan(along[run.at_rest]).all()
    else:
        assert np.isfinite(along).all()


def test_halving_the_step_changes_the_filtered_torque_by_less_than_a_hundredth_of_noise() -> None:
    arm, coarse = simulated("seven", "dry")
    fine = PLANT.simulate(arm, sines(7), step=coarse.time[1] / 2)
    slow = [sosfiltfilt(butter(2, 8.0, fs=1 / r.time[1], output="sos"), r.torque, axis=0) for r in (coarse, fine)]
    moving = np.abs(coarse.v) > 0.02
    assert np.sqrt(np.mean((slow[0] - slow[1][::2])[moving] ** 2)) < 3e-3


@dataclass(frozen=True)
class Weak(Disturbance):
    """Drives that deliver less than is asked, and an instrument that shows more."""

    share: float

    def deliver(self, time: float, v: Array, torque: Array) -> Array:
        return torque - self.share * torque**3 / 1e4

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        return torque + self.share


@pytest.mark.parametrize("disturbance", [Weak(0.2), Rising(1.0)])
def test_disturbances_act_in_motion_and_along_it(disturbance: Disturbance) -> None:
    arm = sample("planar", "smooth", disturbances=(disturbance,))
    run = PLANT.simulate(arm, sines(2))
    np.testing.assert_allclose(PLANT.torque_along(arm, run), run.torque, atol=0.02)
    plain = PLANT.torque_along(replace(arm, disturbances=()), run)
    shown = run.torque - 0.2 if isinstance(disturbance, Weak) else run.torque
    acts = disturbance.deliver(0.0, run.v, shown) - plain
    assert np.abs(acts - (0.0 if isinstance(disturbance, Weak) else run.time[:, None] * [1, 0])).max() < 0.02


def test_a_warmer_arm_rubs_less() -> None:
    arm = sample("planar", "smooth")
    run = PLANT.simulate(arm, sines(2), warmer=10.0)
    assert run.temperature.mean() == pytest.approx(35.0)
    far = np.abs(run.v) > 0.3
    rubs = (run.torque - load_of(arm, run))[far] / steady_friction(arm, run.v)[far]
    np.testing.assert_allclose(rubs, 0.9, atol=1e-3)


def test_a_setting_that_an_effect_does_not_have_is_refused() -> None:
    with pytest.raises(ValueError, match="no setting"):
        PLANT.simulate(
            sample(effects=(HiddenEffect(effect="payload", joints=(), size=1.0, shape={"lenght": 1}),)), still(2)
        )
    with pytest.raises(ValueError, match="expected 1 to 2"):
        PLANT.simulate(sample(effects=(HiddenEffect(effect="backlash", joints=(3,), size=1e-3),)), still(2))


def test_the_plant_knows_neither_the_package_nor_the_other_plant() -> None:
    for file in (Path(__file__).parent / "plant_mujoco").glob("*.py"):
        text = file.read_text(encoding="utf-8")
        assert "physident" not in text
        assert "tests.plant." not in text
