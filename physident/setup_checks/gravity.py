"""How measured gravity torque compares with the description's: gains, motor side, gravity taken out, another robot, upside down.

The factor of the description's gravity is estimated beside inertia, rotor and friction, on the joints where gravity is
large. A description's masses are right to some tens of per cent and a load adds to them, so that a factor from one half
to two is healthy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.setup_checks.finding import SetupFinding, joint_list, within
from physident.setup_checks.jackknife import Interval, jackknife
from physident.setup_checks.joint_fit import (
    Moments,
    coefficients,
    dissipation,
    inertia_factor,
    inertia_factors,
    own_unexplained,
)
from physident.setup_checks.rows import STRONG, Rows

Array = NDArray[np.float64]
HEALTHY = (0.5, 2.0)  # factor of gravity: description and load together
ANOTHER = (0.15, 6.0)  # beyond it no two arms with such joints differ: a unit or a gear ratio does
ABSENT = 0.25  # factor below which gravity counts as taken out, if friction and inertia are as large as ever
MINOR = 0.2  # of friction and inertia: a healthy arm's gravity is larger
UNEXPLAINED = 0.3  # share of variance: where gravity is truly taken out, friction and inertia are all there is
HEALTHY_INERTIA = (0.3, 5.0)  # factor of inertia: rotors add their own, a sensor behind the gear may see less
ANOTHER_INERTIA = (0.15, 10.0)  # inertia grows with the square of lengths
OUT_OF_PROPORTION = 4.0  # inertia's factor over gravity's: rotors make it two
NOTHING = 1e-3  # factor: no gear ratio of an arm is as large as its inverse
MOTOR_SIDE = 1 / 30  # factor: gears of arms have ratios of 30 to 200, and amperes are a tenth of newton metres


@dataclass(frozen=True, eq=False, kw_only=True)
class GravityScale:
    """Factors of the description's gravity torque: ``joints`` (n,) with their intervals, ``strong`` (n,) the joints with much of
    it, ``common`` their mean weighted by gravity. ``size`` (n,) [N m] is the description's gravity torque, ``other`` (n,) [N m] the
    rest of each joint's fitted torque, ``left`` (n,) the share of variance that the fit leaves, ``dissipated`` (n,) [W] the
    power of friction; ``inertia`` is the factor of the description's inertia."""

    joints: Interval
    common: Interval
    strong: NDArray[np.bool_]
    size: Array
    other: Array
    left: Array
    dissipated: Array
    inertia: float


def gravity_scale(rows: Rows, moments: Moments) -> GravityScale | None:
    """The factors of gravity; None for an arm whose gravity torque does not change."""
    columns = rows.columns
    size = columns[:, :, 0].std(axis=1)
    total = rows.centred(rows.torque).std(axis=0)
    if not size.max() > 1e-3 * total.max():
        return None
    strong = (size >= STRONG * size.max()) & (size > 0)
    whole = coefficients(moments)
    replicates = np.array([coefficients(moments, b)[:, 0] for b in range(moments.blocks)])
    weight = np.where(strong, size**2, 0.0) / np.where(strong, size**2, 0.0).sum()
    fitted = columns * whole[:, None, :]
    other = fitted[:, :, 1:].sum(axis=2).std(axis=1)
    return GravityScale(
        joints=jackknife(whole[:, 0], replicates),
        common=jackknife(weight @ whole[:, 0], replicates @ weight),
        strong=strong,
        size=size,
        other=other,
        left=own_unexplained(moments),
        dissipated=dissipation(rows, moments),
        inertia=inertia_factor(rows, moments),
    )


def check_gravity(rows: Rows, moments: Moments, effort_kind: str) -> SetupFinding | None:
    """What the factor of gravity says is wrong; None where it is healthy or not known well enough."""
    scale = gravity_scale(rows, moments)
    if not rows.trusted:
        return None
    if scale is None:
        return _without_gravity(rows, moments, effort_kind)
    low, high, value = float(scale.common.low), float(scale.common.high), float(scale.common.value)
    evidence = f"measured gravity torque is {value:.2g} ({low:.2g} to {high:.2g}) times the description's"
    balanced = _balanced(scale)
    if balanced.any() and _surely_described(scale).any():
        return _single_joints(scale, _absent(scale), balanced, rows.robot.n)
    if _taken_out(scale):
        return SetupFinding(
            kind="gravity_removed",
            joints=(),
            statement="the efforts hold no gravity: the driver or controller takes it out; record raw torques or currents",
            evidence=f"{evidence}, inertia torque {scale.inertia:.2g} times",
            void=True,
        )
    if high < 0 and value < -HEALTHY[0]:
        return _opposite(scale, evidence, rows.robot.n)
    if high < HEALTHY[0] or low > HEALTHY[1]:
        return _wrong_size(scale, evidence, value, effort_kind)
    if not HEALTHY[0] < value < HEALTHY[1] and _outside(scale).any():
        return _wrong_size(scale, evidence, value, effort_kind)  # the arm's factor is not sure, but a joint's is
    return _single_joints(scale, _absent(scale), balanced, rows.robot.n)


def _taken_out(scale: GravityScale) -> bool:
    """Whether little gravity is left beside inertia of full size: what is left is the error of the controller's model."""
    left = abs(float(scale.common.value))
    small = float(scale.common.high) < HEALTHY[0] and left < HEALTHY[0]
    explained = float(np.median(scale.left[scale.strong])) < UNEXPLAINED
    return small and explained and scale.inertia > max(HEALTHY_INERTIA[0], OUT_OF_PROPORTION * left)


def _absent(scale: GravityScale) -> NDArray[np.bool_]:
    """Strong joints (n,) whose gravity is surely small beside the description's and beside their own friction and inertia."""
    near_zero = (scale.joints.low > -ABSENT) & (scale.joints.high < ABSENT)
    small = np.abs(scale.joints.value) * scale.size < MINOR * scale.other
    return scale.strong & near_zero & small & (scale.left < UNEXPLAINED)


def _balanced(scale: GravityScale) -> NDArray[np.bool_]:
    """Strong joints (n,) whose gravity surely has the other sign, while their friction has the right one: where gravity acts elsewhere as
    described, a spring or a counterbalance holds them."""
    return scale.strong & (scale.joints.high < 0) & (scale.dissipated > 0)


def _surely_described(scale: GravityScale) -> NDArray[np.bool_]:
    """Joints (n,) that surely show gravity as the description has it."""
    return (scale.size > 0) & (scale.joints.low > HEALTHY[0]) & (scale.joints.high < HEALTHY[1])


def _opposite(scale: GravityScale, evidence: str, n: int) -> SetupFinding:
    """Gravity of the wrong sign: where friction is of the right one, the arm hangs the other way round."""
    driving = scale.strong & (scale.dissipated < 0)
    if driving.any():
        joints = tuple(int(j) + 1 for j in np.flatnonzero(driving))
        return SetupFinding(
            kind="effort_sign",
            joints=joints,
            statement=f"the effort of {within(joints, n)} has the wrong sign; its friction drives the motion: turn the sign over",
            evidence=evidence,
            void=True,
        )
    return SetupFinding(
        kind="gravity_direction",
        joints=(),
        statement="gravity acts in the opposite direction: the arm hangs where the description stands, or the other way round;"
        " correct gravity or the base of the description",
        evidence=evidence,
        void=True,
    )


def _without_gravity(rows: Rows, moments: Moments, effort_kind: str) -> SetupFinding | None:
    """The same for an arm whose gravity torque does not change, by its inertia with that of its rotors, which may be many times that of a wrist:
    where only some joints move, more than the description's says nothing."""
    if (light := _light_joints(rows, moments)) is not None:
        return light
    replicates = np.array([inertia_factor(rows, moments, b) for b in range(moments.blocks)])
    found = jackknife(np.array(inertia_factor(rows, moments)), replicates)
    if not np.isfinite(found.value):
        return None
    too_large = float(found.low) >= HEALTHY_INERTIA[1] and rows.moving().all()
    if float(found.high) > HEALTHY_INERTIA[0] and not too_large:
        return None
    value = float(found.value)
    evidence = f"measured inertia torque is {value:.2g} ({float(found.low):.2g} to {float(found.high):.2g}) times the description's"
    return _size_finding(evidence, value, effort_kind, ANOTHER_INERTIA)


def _light_joints(rows: Rows, moments: Moments) -> SetupFinding | None:
    """Joints whose inertia is surely less than that of any links like the description's, while others' is not: rotors only add.
    Where it is small beside friction, nothing is known: the described inertia alone has to be more than all that was measured."""
    replicates = np.array([inertia_factors(rows, moments, b) for b in range(moments.blocks)])
    own = jackknife(inertia_factors(rows, moments), replicates)
    described, measured = rows.columns[:, :, 1].std(axis=1), rows.centred(rows.torque).std(axis=0)
    light = (own.high < MOTOR_SIDE) & (described > measured)
    if not light.any() or light[rows.strong()].all():
        return None
    joints = tuple(int(j) + 1 for j in np.flatnonzero(light))
    listed = ", ".join(f"{own.value[j - 1]:.2g} on joint {j}" for j in joints)
    evidence = f"factor of the description's inertia: {listed}"
    return _out_of_proportion(joints, evidence, ("the description's inertia is a placeholder",))


def _out_of_proportion(joints: tuple[int, ...], evidence: str, rivals: tuple[str, ...] = ()) -> SetupFinding:
    return SetupFinding(
        kind="joint_gain",
        joints=joints,
        statement=f"the effort of {joint_list(joints)} is out of proportion with the other joints; check its drive gain or unit",
        evidence=evidence,
        void=True,
        rivals=rivals,
    )


def _wrong_size(scale: GravityScale, evidence: str, value: float, effort_kind: str) -> SetupFinding:
    strong = np.flatnonzero(scale.strong)
    alike = (scale.joints.high[strong] < HEALTHY[0]).all() or (scale.joints.low[strong] > HEALTHY[1]).all()
    return _size_finding(evidence, value, effort_kind, ANOTHER if alike else (0.0, np.inf))


def _size_finding(evidence: str, value: float, effort_kind: str, another: tuple[float, float]) -> SetupFinding:
    """Efforts of another size than the description's: of another robot within ``another``, else in another unit."""
    if value < NOTHING:
        return SetupFinding(
            kind="effort_unlike",
            joints=(),
            statement="the efforts do not follow the description's gravity: check the effort columns, the robot, and whether the"
            " driver takes gravity out",
            evidence=evidence,
            void=True,
        )
    if effort_kind == "current":
        what = (
            f"the drive gains are {1 / value:.2g} times too small"
            if value < 1
            else f"the drive gains are {value:.2g} times too large"
        )
        kind, cure = "drive_gains", "correct the drive gains [N m/A]"
    elif value < MOTOR_SIDE:
        kind, what, cure = (
            "motor_torque",
            "the efforts are torques of the motors, before the gears",
            "multiply by gear ratio",
        )
    elif value < 1:
        kind, what, cure = (
            "motor_current",
            "the efforts are motor currents [A], not torques",
            "name them current and give drive gains",
        )
    else:
        kind, what, cure = "effort_unit", "the efforts are in another unit than N m", "convert them to N m"
    other = "the description is of another robot than the recording"
    if another[0] < value < another[1]:
        return SetupFinding(
            kind="description",
            joints=(),
            statement=f"{other}; check the robot",
            evidence=evidence,
            void=True,
            rivals=(what,),
        )
    rivals = (other,) if another[0] / 2 < value < another[1] * 2 else ()
    return SetupFinding(kind=kind, joints=(), statement=f"{what}; {cure}", evidence=evidence, void=True, rivals=rivals)


def _outside(scale: GravityScale) -> NDArray[np.bool_]:
    """Strong joints (n,) whose factor is surely beyond that of any description or load."""
    return scale.strong & ((scale.joints.high < ANOTHER[0]) | (scale.joints.low > ANOTHER[1]))


def _single_joints(
    scale: GravityScale, absent: NDArray[np.bool_], balanced: NDArray[np.bool_], n: int
) -> SetupFinding | None:
    """Strong joints whose own factor is beyond what any description, load or spring explains, while the arm's is healthy."""
    outside = (_outside(scale) | absent) & ~balanced
    if not outside.any():
        return None
    joints = tuple(int(j) + 1 for j in np.flatnonzero(outside))
    listed = ", ".join(f"{scale.joints.value[j - 1]:.2g} on joint {j}" for j in joints)
    evidence = f"factor of the description's gravity: {listed}, {float(scale.common.value):.2g} on the arm"
    if absent[outside].all():
        return SetupFinding(
            kind="mixture",
            joints=joints,
            statement=f"gravity is taken out of the efforts of {within(joints, n)} but not of the others; record one kind of channel",
            evidence=evidence,
            void=True,
        )
    return _out_of_proportion(joints, evidence)


def fits_well(moments: Moments) -> bool:
    """Whether the description explains most of the efforts as they are."""
    return bool(np.median(own_unexplained(moments)) < 0.5)
