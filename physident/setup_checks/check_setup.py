"""All checks of a set-up, in the order in which one mistake hides another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from physident.errors import InputError, warn
from physident.recordings.load import Recordings, as_recordings
from physident.recordings.recording import Recording
from physident.robots.load import as_robot
from physident.robots.robot import Robot
from physident.setup_checks.channel import check_channel
from physident.setup_checks.finding import SetupFinding
from physident.setup_checks.gravity import check_gravity, fits_well
from physident.setup_checks.joint_fit import Moments, moments_of
from physident.setup_checks.order import TWICE, check_labels, check_order
from physident.setup_checks.position import check_positions, check_zeros, upside_down_gain
from physident.setup_checks.rows import Rows, rows_of
from physident.setup_checks.samples import check_samples
from physident.setup_checks.still import check_frozen, check_still
from physident.setup_checks.timing import check_delay
from physident.setup_checks.velocity import check_velocity

LONG = 400_000  # rows that are all looked at: a quarter of an hour at 500 Hz
EXTRACTS = 4


def check_setup(robot: Robot | str | Path | None, recordings: Recordings) -> tuple[SetupFinding, ...]:
    """What is wrong with the way recordings were made or declared, and what their effort channel is; empty where all is well.

    Held against each other are the channels of the recordings themselves, and, unless ``robot`` is None, efforts and
    positions against the description's gravity, inertia and limits and against the passivity of friction. Findings whose
    ``void`` is True make a model of these recordings wrong. ``robot`` may be a name or a path, ``recordings`` one or several
    recordings, paths or patterns. Raises InputError for recordings with other numbers of joints.
    """
    robot = None if robot is None else as_robot(robot)
    chosen = as_recordings(recordings, robot)
    if not chosen:
        return ()
    for recording in chosen:
        expected = chosen[0].n if robot is None else robot.n
        if recording.n != expected:
            whose = "the first recording" if robot is None else f"robot {robot.name}"
            raise InputError(
                f"{recording.source}: {recording.n} joints, but {whose} has {expected}; check --robot and --columns"
            )
    chosen = [part for recording in chosen for part in _extracts(recording)]
    frozen = check_frozen(chosen)
    found = [*check_velocity(chosen), *check_samples(chosen), *([frozen] if frozen else [])]
    if frozen is not None:  # nothing that the description asks can be held against a position that is not the joint's
        robot = None
    if robot is not None and not any(finding.kind == "position_velocity_swapped" for finding in found):
        found += _of_robot(robot, chosen)
    return tuple(sorted(found, key=lambda finding: not finding.void))


def _extracts(recording: Recording) -> list[Recording]:
    """Parts of a long recording, evenly over its length; a shorter one as it is. A wrong set-up is wrong all along."""
    count, length = len(recording.time), LONG // EXTRACTS
    if count <= LONG:
        return [recording]
    starts = np.linspace(0, count - length, EXTRACTS).astype(int).tolist()
    return [recording.part(slice(start, start + length)) for start in starts]


def check_setup_of_each(robot: Robot | None, *groups: Sequence[Recording]) -> tuple[SetupFinding, ...]:
    """The findings on all recordings together, and the void ones on each group of them, such as a holdout that others outweigh."""
    given = [group for group in groups if group]
    found = list(check_setup(robot, [recording for group in given for recording in group]))
    for group in given if len(given) > 1 else ():
        told = {(finding.kind, finding.joints) for finding in found}
        found += [one for one in check_setup(robot, group) if one.void and (one.kind, one.joints) not in told]
    return tuple(found)


def warn_of_setup(robot: Robot | None, *groups: Sequence[Recording]) -> tuple[str, ...]:
    """Warn of everything that is wrong with a set-up, or, without a robot, between the channels; return what was said."""
    texts = tuple(str(finding) for finding in check_setup_of_each(robot, *groups) if not finding.note)
    for text in texts:
        warn(text)
    return texts


def _of_robot(robot: Robot, recordings: Sequence[Recording]) -> Iterator[SetupFinding]:
    """What positions and efforts say about the description: the first mistake, since it would spoil the checks after it."""
    rows = rows_of(robot, recordings)
    if rows is None:
        return
    moments = moments_of(rows)
    first = (
        check_still(rows, moments, recordings)
        or check_positions(rows, moments, unit=True)
        or check_order(rows, moments)
    )
    zero = None if first is not None else check_zeros(rows, moments)
    first = (
        first
        or check_labels(rows, moments, than=0.0 if zero is None else zero[0])
        or (None if zero is None else _zero_or_upside_down(rows, moments, recordings, *zero))
        or check_positions(rows, moments, unit=False)
        or check_gravity(rows, moments, recordings[0].effort_kind)
    )
    if first is not None:
        yield first
        return
    channel = check_channel(rows, moments, recordings)
    if channel is not None:
        yield channel
    if fits_well(moments) and (delay := check_delay(rows)) is not None:
        yield delay


def _zero_or_upside_down(
    rows: Rows, moments: Moments, recordings: Sequence[Recording], gain: float, zero: SetupFinding
) -> SetupFinding:
    """The zero of a joint; an arm that hangs upside down, with the zero as its rival, where both explain the efforts alike."""
    gravity = check_gravity(rows, moments, recordings[0].effort_kind)
    if gravity is None or gravity.kind != "gravity_direction" or gain > upside_down_gain(rows, moments) + TWICE:
        return zero
    return replace(gravity, rivals=(*gravity.rivals, zero.statement.partition(";")[0]))
