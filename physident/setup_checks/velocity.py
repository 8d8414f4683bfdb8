"""Measured velocity against the derivative of position: sign, unit, order, scale, delay, or the two channels swapped."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.recordings.preparation import differentiate
from physident.recordings.recording import Recording
from physident.recordings.signals import MOVING_SPEED
from physident.setup_checks.finding import SetupFinding, joint_list, within
from physident.setup_checks.jackknife import jackknife
from physident.setup_checks.rows import BLOCKS, filter_for

Array = NDArray[np.float64]
ALIKE = 0.9  # correlation of two velocities of one joint; noise and a delay of a tenth of a period leave more
UNLIKE = 0.3  # relative difference of two velocities of one joint: a delay of a few samples and noise leave less
SAME = 0.98  # correlation of position with the derivative of what should be velocity, where the two are swapped
DEGREES = 180 / np.pi
TOLERANCE = 0.1  # relative: a differentiated position is never as wrong as that where the joint moves
GEAR = 20.0  # a velocity as many times too fast is that of a motor
LATE = 0.01  # s: at 5 Hz it turns the phase by 18 degrees, which a model takes for friction or inertia


@dataclass(frozen=True, eq=False, kw_only=True)
class Velocities:
    """Filtered rows (M, n) in motion: ``measured`` velocity, ``derived`` from position [rad/s], the latter's ``slope``
    [rad/s^2]; ``block`` (M,)."""

    measured: Array
    derived: Array
    slope: Array
    block: NDArray[np.intp]
    step: float


def check_velocity(recordings: Sequence[Recording]) -> Iterator[SetupFinding]:
    """Contradictions between the measured velocity and the positions of recordings that measure both."""
    both = [recording for recording in recordings if recording.dq is not None]
    if (swapped := _swapped(both)) is not None:
        yield swapped
        return
    rows = _velocities(both)
    if rows is None:
        return
    moving = np.abs(rows.derived).max(axis=0) > 2 * MOVING_SPEED
    n = len(moving)
    if not moving.any():
        return
    own = _likeness(rows.derived, rows.measured)
    agree = np.abs(own) >= ALIKE
    if (order := _order(rows, moving)) is not None:
        yield order
        return
    wrong = moving & ~agree
    if wrong.any():
        yield _unlike(own, wrong, n)
        return
    yield from _scales(rows, moving)
    yield from _delay(rows, moving)


def _swapped(recordings: Sequence[Recording]) -> SetupFinding | None:
    """Positions in the columns of velocity and the reverse: the derivative of what should be velocity is what should be position."""
    turned = [replace(r, q=np.array(r.dq), dq=np.array(r.q)) for r in recordings if r.dq is not None]
    rows = _velocities(turned)
    if rows is None:
        return None
    moving = np.abs(rows.derived).max(axis=0) > 2 * MOVING_SPEED
    size = np.maximum((rows.derived**2).sum(axis=0), 1e-30)
    factor = (rows.measured * rows.derived).sum(axis=0) / size
    # a position has a zero of its own
    alike = _likeness(*(x - x.mean(axis=0) for x in (rows.derived, rows.measured)))
    if not moving.any() or not ((alike > SAME) & (np.abs(factor - 1) < TOLERANCE))[moving].all():
        return None
    return SetupFinding(
        kind="position_velocity_swapped",
        joints=(),
        statement="the columns of q and dq are swapped: the derivative of dq is q; correct --columns",
        evidence=f"correlation at least {alike[moving].min():.3f}",
        void=True,
    )


def _order(rows: Velocities, moving: NDArray[np.bool_]) -> SetupFinding | None:
    """Velocities that are exactly those of other joints."""
    from scipy.optimize import linear_sum_assignment

    size = np.maximum(np.linalg.norm(rows.derived, axis=0), 1e-12)
    # row j: how far each column of velocity is from the derivative of position j
    apart = np.linalg.norm(rows.measured[:, None, :] - rows.derived[:, :, None], axis=0) / size[:, None]
    _, order = linear_sum_assignment(np.minimum(apart, 10.0))
    n = len(order)
    changed = order != np.arange(n)
    own, other = np.diag(apart), apart[np.arange(n), order]
    if (
        not (changed & moving).any()
        or not (other[changed & moving] < np.minimum(UNLIKE, own[changed & moving] / 2)).all()
    ):
        return None
    joints = tuple(int(j) + 1 for j in np.flatnonzero(changed))
    text = ", ".join(f"column {order[j - 1] + 1} is joint {j}" for j in joints)
    how = "swapped" if len(joints) == 2 else f"in another order than the positions: {text}"
    return SetupFinding(
        kind="velocity_order",
        joints=joints,
        statement=f"the velocities of {joint_list(joints)} are {how}; correct the columns of dq",
        evidence=f"they differ from the derivative of position by {100 * own[changed].max():.0f} % as they are and"
        f" {100 * other[changed].max():.0f} % so",
        void=True,
    )


def _unlike(own: Array, wrong: NDArray[np.bool_], n: int) -> SetupFinding:
    """Velocities that do not follow their positions."""
    joints = tuple(int(j) + 1 for j in np.flatnonzero(wrong))
    return SetupFinding(
        kind="velocity_unlike",
        joints=joints,
        statement=f"the measured velocity of {within(joints, n)} does not follow its position; leave dq out or correct its columns",
        evidence=f"correlation with the derivative of position {np.abs(own)[wrong].min():.2f}, expected above {ALIKE}",
        void=True,
    )


def _scales(rows: Velocities, moving: NDArray[np.bool_]) -> Iterator[SetupFinding]:
    """Velocities that are their position's derivative times a factor, and the factor's name."""
    factor = (rows.measured * rows.derived).sum(axis=0) / np.maximum((rows.derived**2).sum(axis=0), 1e-30)
    n = len(factor)
    kinds: dict[str, list[int]] = {}
    for j in np.flatnonzero(moving):
        if (kind := _kind_of(float(factor[j]))) is not None:
            kinds.setdefault(kind, []).append(int(j) + 1)
    texts = {
        "velocity_sign": ("has the wrong sign", "turn the sign of dq over"),
        "velocity_degrees": ("is in degrees per second", "convert dq to rad/s"),
        "position_degrees": (
            "is 1/57.3 of the derivative of position: the positions are in degrees",
            "convert q to radians",
        ),
        "velocity_motor": ("is that of the motor, before the gear", "divide dq by the gear ratio"),
        "position_motor": (
            "shows that the positions are those of the motor, before the gear",
            "divide q by the gear ratio",
        ),
        "velocity_scale": ("is the derivative of position times a factor", "correct the unit or clock of q and dq"),
    }
    for kind, joints in kinds.items():
        what, cure = texts[kind]
        sizes = [abs(factor[j - 1]) if kind != "velocity_sign" else factor[j - 1] for j in joints]
        yield SetupFinding(
            kind=kind,
            joints=tuple(joints),
            statement=f"the measured velocity of {within(joints, n)} {what}; {cure}",
            evidence=f"dq is {_span(sizes)} times the derivative of q",
            void=True,
        )


def _kind_of(factor: float) -> str | None:
    size = abs(factor)
    if abs(size / DEGREES - 1) < TOLERANCE:
        return "velocity_degrees"
    if abs(size * DEGREES - 1) < TOLERANCE:
        return "position_degrees"
    if size > GEAR:
        return "velocity_motor"
    if size < 1 / GEAR:
        return "position_motor"
    if abs(size - 1) > TOLERANCE:
        return "velocity_scale"
    return "velocity_sign" if factor < 0 else None


def _delay(rows: Velocities, moving: NDArray[np.bool_]) -> Iterator[SetupFinding]:
    """A velocity later than the position: by a delay, or by a filter, which is late for slow motion."""
    used = np.unique(rows.block)
    tops, bottoms = [], []
    for block in used:
        chosen = rows.block == block
        slope, difference = rows.slope[chosen], rows.measured[chosen] - rows.derived[chosen]
        tops.append(-(slope * difference).sum(axis=0))
        bottoms.append((slope**2).sum(axis=0))
    top, bottom = np.array(tops), np.maximum(np.array(bottoms), 1e-30)
    replicates = np.array([np.delete(top, b, 0).sum(0) / np.delete(bottom, b, 0).sum(0) for b in range(len(used))])
    found = jackknife(top.sum(axis=0) / bottom.sum(axis=0), replicates)
    late = moving & (found.low > max(LATE, rows.step))
    if late.any():
        joints = tuple(int(j) + 1 for j in np.flatnonzero(late))
        most = int(np.argmax(np.where(late, found.value, -np.inf)))
        yield SetupFinding(
            kind="velocity_late",
            joints=joints,
            statement=f"the measured velocity of {within(joints, len(late))} is late: it was filtered or delayed; leave dq out,"
            " and velocity is derived from position",
            evidence=f"by {1e3 * found.value[most]:.0f} ms ({1e3 * found.low[most]:.0f} to {1e3 * found.high[most]:.0f}) on joint {most + 1}",
            void=False,
        )  # fmt: skip


def _velocities(recordings: Sequence[Recording]) -> Velocities | None:
    """Filtered rows of all contiguous parts of each recording."""
    parts = [part for recording in recordings for part in _of_recording(recording)]
    if not parts:
        return None
    names = ("measured", "derived", "slope")
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    count = len(joined["measured"])
    return Velocities(**joined, block=np.arange(count) * BLOCKS // count, step=max(part.step for part in parts))


def _of_recording(recording: Recording) -> Iterator[Velocities]:
    assert recording.dq is not None
    filter = filter_for(recording)
    try:
        signals = differentiate(replace(recording, dq=None, effort=recording.dq, effort_kind="torque"), filter)
    except InputError:
        return
    for part in map(signals.part, signals.segments):
        assert part.torque is not None
        channels = (part.torque, part.v, np.gradient(part.v, 1 / signals.rate, axis=0))
        measured, derived, slope = (filter.apply(np.ascontiguousarray(x.T), signals.rate).T for x in channels)
        yield Velocities(
            measured=measured,
            derived=derived,
            slope=slope,
            block=np.zeros(len(measured), dtype=np.intp),
            step=1 / signals.rate,
        )


def _likeness(first: Array, second: Array) -> Array:
    """Correlation (n,) about zero of the columns of two arrays (M, n), because a velocity has no offset, and one that is held is as much like
    itself; zero where one is zero."""
    size = np.linalg.norm(first, axis=0) * np.linalg.norm(second, axis=0)
    return (first * second).sum(axis=0) / np.where(size > 0, size, 1.0)


def _span(values: list[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:.3g}" if f"{low:.3g}" == f"{high:.3g}" else f"{low:.3g} to {high:.3g}"
