"""Effort channels of other kinds, made of a simulated arm's recordings, each with the finding that names it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.dynamics.inverse_dynamics import gravity_torque, inverse_dynamics
from studies.setup_checks.arms import Arm
from studies.setup_checks.mistakes import Wrong

Array = NDArray[np.float64]
Rng = np.random.Generator
DELAY = 0.06  # s of the efforts behind the positions
FILTER = 0.04  # s: time constant of a first-order filter of the velocity


def motor_current(arm: Arm, rng: Rng) -> Wrong:
    """Amperes that are taken for newton metres, 8 to 14 N m/A."""
    gains = rng.uniform(8.0, 14.0, arm.robot.n)
    return _with(arm, lambda r, _: replace(r, effort=r.effort / gains), "motor_current")


def motor_torque(arm: Arm, rng: Rng) -> Wrong:
    """Torques before gears of 80 to 120."""
    ratios = rng.uniform(80.0, 120.0, arm.robot.n)
    return _with(arm, lambda r, _: replace(r, effort=r.effort / ratios), "motor_torque")


def link_side(arm: Arm, rng: Rng) -> Wrong:
    """A torque sensor behind the gear: links without rotors, 2 % of friction, 1 % of noise."""

    def make(r: pid.Recording, k: int) -> pid.Recording:
        torque = _rigid(arm, r, k, true=True)
        size = torque.std(axis=0)
        v = _plan(arm, r, k)[1]
        return replace(r, effort=torque + 0.02 * size * np.sign(v) + 0.01 * size * rng.standard_normal(torque.shape))

    return _with(arm, make, "link_side")


def model_torque(arm: Arm, rng: Rng) -> Wrong:
    """What a controller computes from the plan and its own model of the links."""
    return _with(arm, lambda r, k: replace(r, effort=_rigid(arm, r, k, true=False)), "model_torque")


def gravity_removed(arm: Arm, rng: Rng) -> Wrong | None:
    """The driver takes the description's gravity out; None for an arm whose gravity torque does not change."""
    if (
        gravity_torque(arm.robot, arm.robot.nominal, np.asarray(arm.recordings[0].q), np.array(arm.robot.gravity))
        .std(axis=0)
        .max()
        < 1e-6
    ):
        return None

    def make(r: pid.Recording, _: int) -> pid.Recording:
        g = gravity_torque(arm.robot, arm.robot.nominal, np.asarray(r.q), np.array(arm.robot.gravity))
        return replace(r, effort=r.effort - g)

    return _with(arm, make, "gravity_removed")


def mixture(arm: Arm, rng: Rng) -> Wrong:
    """A model's torque on the first half of the joints, measured ones on the others."""
    half = arm.robot.n // 2

    def make(r: pid.Recording, k: int) -> pid.Recording:
        return replace(r, effort=np.column_stack([_rigid(arm, r, k, true=False)[:, :half], r.effort[:, half:]]))

    return _with(arm, make, "mixture", joints=tuple(range(1, half + 1)))


def delayed(arm: Arm, rng: Rng) -> Wrong:
    """Efforts that come later than the positions."""

    def make(r: pid.Recording, _: int) -> pid.Recording:
        return replace(r, effort=np.column_stack([np.interp(r.time - DELAY, r.time, column) for column in r.effort.T]))

    return _with(arm, make, "effort_delay")


def filtered_velocity(arm: Arm, rng: Rng) -> Wrong:
    """A velocity that passed a first-order filter."""

    def make(r: pid.Recording, _: int) -> pid.Recording:
        v = np.gradient(r.q, r.time, axis=0) if r.dq is None else np.array(r.dq)
        share = 1 - np.exp(-np.diff(r.time) / FILTER)
        for k in range(1, len(v)):
            v[k] = v[k - 1] + share[k - 1] * (v[k] - v[k - 1])
        return replace(r, dq=v)

    return _with(arm, make, "velocity_late")


def saturated(arm: Arm, rng: Rng) -> Wrong:
    """Drives that end at 60 % of the largest effort of the joint."""

    def make(r: pid.Recording, _: int) -> pid.Recording:
        most = 0.6 * np.abs(r.effort).max(axis=0)
        return replace(r, effort=np.clip(r.effort, -most, most))

    return _with(arm, make, "saturation")


def quantised(arm: Arm, rng: Rng) -> Wrong:
    """Efforts in steps of a third of their standard deviation."""

    def make(r: pid.Recording, _: int) -> pid.Recording:
        step = r.effort.std(axis=0) / 3
        return replace(r, effort=np.round(r.effort / step) * step)

    return _with(arm, make, "quantisation")


CHANNELS = (
    motor_current, motor_torque, link_side, model_torque, gravity_removed, mixture, delayed, filtered_velocity, saturated,
    quantised,
)  # fmt: skip


def _with(
    arm: Arm, change: Callable[[pid.Recording, int], pid.Recording], kind: str, joints: tuple[int, ...] = ()
) -> Wrong:
    return Wrong(arm.robot, lambda: [change(r, k) for k, r in enumerate(arm.recordings)], (kind,), joints)


def _plan(arm: Arm, r: pid.Recording, k: int) -> tuple[Array, Array, Array]:
    return arm.plans[k].states(np.asarray(r.time))


def _rigid(arm: Arm, r: pid.Recording, k: int, true: bool) -> Array:
    """Torque (N, n) of links and gravity along the plan: of the arm's ``true`` links or of the description's."""
    assert arm.truth is not None
    links = arm.truth.links.ravel() if true else np.asarray(arm.robot.nominal)
    return inverse_dynamics(arm.robot, links, *_plan(arm, r, k))
