"""Mistakes that people make in a set-up, made to healthy recordings, each with the finding that names it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.setup_checks.rows import rows_of
from studies.setup_checks.arms import Arm, recorded, robot_of

Array = NDArray[np.float64]
Rng = np.random.Generator


@dataclass(frozen=True, eq=False)
class Wrong:
    """What the user has after a mistake: description and recordings; the kinds that name it, and its joints (from 1)."""

    robot: pid.Robot
    make: Callable[[], list[pid.Recording]]
    kinds: tuple[str, ...]
    joints: tuple[int, ...] = ()


def _with(
    arm: Arm, change: Callable[[pid.Recording], pid.Recording], *kinds: str, joints: tuple[int, ...] = ()
) -> Wrong:
    return Wrong(arm.robot, lambda: [change(r) for r in arm.recordings], kinds, joints)


def _again(r: pid.Recording, q: Array, dq: Array | None) -> pid.Recording:
    """The recording with other motion, as its file would be read."""
    again = recorded(r.time, q, r.effort, dq, r.effort_kind, r.source)
    return again if r.drive_gains is None else again.with_drive_gains(r.drive_gains)


def all_signs(arm: Arm, rng: Rng) -> Wrong:
    """All efforts have the wrong sign."""
    return _with(arm, lambda r: replace(r, effort=-r.effort), "effort_sign", joints=_all(arm))


def one_sign(arm: Arm, rng: Rng) -> Wrong:
    """The effort of one joint has the wrong sign."""
    j = int(rng.integers(arm.robot.n))
    sign = np.where(np.arange(arm.robot.n) == j, -1.0, 1.0)
    return _with(arm, lambda r: replace(r, effort=r.effort * sign), "effort_sign", joints=(j + 1,))


def gains_a_tenth(arm: Arm, rng: Rng) -> Wrong:
    """Drive gains a tenth of the right ones."""
    return _with(arm, lambda r: _current(r, 0.1), "drive_gains")


def gains_tenfold(arm: Arm, rng: Rng) -> Wrong:
    """Drive gains ten times the right ones."""
    return _with(arm, lambda r: _current(r, 10.0), "drive_gains")


def another_robot(arm: Arm, rng: Rng) -> Wrong:
    """The description of a sister arm, with 1.6 times the lengths and 2.5 times the masses."""
    return Wrong(sister(arm.robot), lambda: list(arm.recordings), ("description",))


def efforts_swapped(arm: Arm, rng: Rng) -> Wrong:
    """The effort columns of two neighbouring joints are swapped."""
    order, joints = _swap(arm, rng)
    return _with(arm, lambda r: replace(r, effort=r.effort[:, order]), "effort_order", joints=joints)


def joints_swapped(arm: Arm, rng: Rng) -> Wrong:
    """All columns of two neighbouring joints among the first three are swapped."""
    order, joints = _swap(arm, rng, 3)
    return _with(arm, lambda r: _reordered(r, order), "joint_order", joints=joints)


def joint_turned(arm: Arm, rng: Rng) -> Wrong:
    """A joint that carries weight turns the other way than its description, position and effort alike."""
    return _placed(arm, rng, -1.0, 0.0)


def joint_zero(arm: Arm, rng: Rng) -> Wrong:
    """The zero of a joint that carries weight is 90 degrees off."""
    return _placed(arm, rng, 1.0, float(rng.choice([-0.5, 0.5])) * np.pi)


def position_turned(arm: Arm, rng: Rng) -> Wrong:
    """The position and velocity of a joint that carries weight count the other way, its effort does not."""
    here = np.arange(arm.robot.n) == _strong(arm, rng)
    sign = np.where(here, -1.0, 1.0)

    def change(r: pid.Recording) -> pid.Recording:
        return replace(r, q=sign * r.q, dq=None if r.dq is None else sign * r.dq)

    return _with(arm, change, "position_sign", joints=(int(np.flatnonzero(here)[0]) + 1,))


def encoder_frozen(arm: Arm, rng: Rng) -> Wrong:
    """The position of a joint that carries weight stays where it began."""
    here = np.arange(arm.robot.n) == _strong(arm, rng)

    def change(r: pid.Recording) -> pid.Recording:
        return replace(r, q=np.where(here, r.q[0], r.q), dq=None if r.dq is None else np.where(here, 0.0, r.dq))

    return _with(arm, change, "position_frozen", joints=(int(np.flatnonzero(here)[0]) + 1,))


def efforts_reversed(arm: Arm, rng: Rng) -> Wrong:
    """The effort columns are in reverse order."""
    n = arm.robot.n
    moved = tuple(j + 1 for j in range(n) if j != n - 1 - j)
    return _with(arm, lambda r: replace(r, effort=r.effort[:, ::-1].copy()), "effort_order", joints=moved)


def q_and_dq_swapped(arm: Arm, rng: Rng) -> Wrong:
    """Positions in the columns of velocities and the reverse."""
    return _with(arm, lambda r: _again(r, _dq(r), r.q), "position_velocity_swapped")


def positions_in_degrees(arm: Arm, rng: Rng) -> Wrong:
    """Positions and velocities in degrees."""
    k = 180 / np.pi
    return _with(arm, lambda r: _again(r, k * r.q, None if r.dq is None else k * r.dq), "position_degrees")


def motor_positions(arm: Arm, rng: Rng) -> Wrong:
    """Positions and velocities of motors with gears of 100."""
    return _with(
        arm, lambda r: _again(r, 100 * r.q, None if r.dq is None else 100 * r.dq), "position_motor", "position_range"
    )


def dq_sign(arm: Arm, rng: Rng) -> Wrong:
    """Velocities have the wrong sign."""
    return _with(arm, lambda r: replace(r, dq=-_dq(r)), "velocity_sign", joints=_all(arm))


def dq_degrees(arm: Arm, rng: Rng) -> Wrong:
    """Velocities in degrees per second, positions in radians."""
    return _with(arm, lambda r: replace(r, dq=180 / np.pi * _dq(r)), "velocity_degrees", joints=_all(arm))


def dq_swapped(arm: Arm, rng: Rng) -> Wrong:
    """The velocity columns of two neighbouring joints are swapped."""
    order, joints = _swap(arm, rng)
    return _with(arm, lambda r: replace(r, dq=_dq(r)[:, order]), "velocity_order", joints=joints)


def dq_scaled(arm: Arm, rng: Rng) -> Wrong:
    """Velocities twice too large."""
    return _with(arm, lambda r: replace(r, dq=2 * _dq(r)), "velocity_scale", joints=_all(arm))


MISTAKES = (
    all_signs, one_sign, gains_a_tenth, gains_tenfold, another_robot, efforts_swapped, joints_swapped, joint_turned, joint_zero, position_turned,
    encoder_frozen, efforts_reversed, q_and_dq_swapped, positions_in_degrees, motor_positions, dq_sign, dq_degrees, dq_swapped, dq_scaled,
)  # fmt: skip


def sister(robot: pid.Robot, length: float = 1.6, mass: float = 2.5) -> pid.Robot:
    """The robot with other lengths and masses."""
    root = ET.fromstring(robot.urdf)
    for parent in root.iter():
        for origin in parent.findall("origin"):
            if parent.tag in ("joint", "inertial") and "xyz" in origin.attrib:
                origin.set("xyz", " ".join(f"{length * float(x):.12g}" for x in origin.attrib["xyz"].split()))
    for weight in root.iter("mass"):
        weight.set("value", f"{mass * float(weight.attrib['value']):.12g}")
    for inertia in root.iter("inertia"):
        for key, value in inertia.attrib.items():
            inertia.set(key, f"{mass * length**2 * float(value):.12g}")
    return robot_of(ET.tostring(root, encoding="unicode"))


def _placed(arm: Arm, rng: Rng, direction: float, zero: float) -> Wrong:
    j = _strong(arm, rng)
    here = np.arange(arm.robot.n) == j
    sign = np.where(here, direction, 1.0)

    def change(r: pid.Recording) -> pid.Recording:
        dq = None if r.dq is None else sign * r.dq
        return replace(r, q=sign * r.q + here * zero, dq=dq, effort=sign * r.effort)

    return _with(arm, change, "joint_place", joints=(j + 1,))


def _strong(arm: Arm, rng: Rng) -> int:
    """One of the joints (from 0) on which inertia and gravity are large."""
    rows = rows_of(arm.robot, arm.recordings)
    assert rows is not None
    return int(rng.choice(np.flatnonzero(rows.strong())))


def _all(arm: Arm) -> tuple[int, ...]:
    return tuple(range(1, arm.robot.n + 1))


def _swap(arm: Arm, rng: Rng, among: int = 99) -> tuple[NDArray[np.intp], tuple[int, ...]]:
    n = arm.robot.n
    j = int(rng.integers(min(among, n) - 1))
    order = np.arange(n)
    order[[j, j + 1]] = j + 1, j
    return order, (j + 1, j + 2)


def _dq(r: pid.Recording) -> Array:
    """The measured velocity, or that of somebody who differentiated the positions."""
    return np.gradient(r.q, r.time, axis=0) if r.dq is None else np.asarray(r.dq)


def _current(r: pid.Recording, factor: float) -> pid.Recording:
    """The recording as currents with wrong drive gains."""
    if r.drive_gains is not None:
        return r.with_drive_gains([factor * g for g in r.drive_gains])
    return replace(r, effort=r.effort / 10.0, effort_kind="current", drive_gains=(10.0 * factor,) * r.n)


def _reordered(r: pid.Recording, order: NDArray[np.intp]) -> pid.Recording:
    gains = None if r.drive_gains is None else tuple(r.drive_gains[k] for k in order)
    dq = None if r.dq is None else r.dq[:, order]
    return replace(r, q=r.q[:, order], dq=dq, effort=r.effort[:, order], drive_gains=gains)
