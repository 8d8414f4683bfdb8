"""All checks of a set-up, in the order in which one mistake hides another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from physident.recordings.recording import Recording
from physident.robots.robot import Robot
from physident.setup_checks.finding import SetupFinding
from physident.setup_checks.gravity import check_gravity
from physident.setup_checks.joint_fit import moments_of
from physident.setup_checks.order import check_labels, check_order
from physident.setup_checks.rows import rows_of


def check_setup(robot: Robot, recordings: Sequence[Recording]) -> tuple[SetupFinding, ...]:
    """What is wrong with the way recordings were set up for a robot's description, worst first; empty where nothing is."""
    chosen = [recordings] if isinstance(recordings, Recording) else list(recordings)
    return tuple(_physics(robot, chosen))


def _physics(robot: Robot, recordings: Sequence[Recording]) -> Iterator[SetupFinding]:
    rows = rows_of(robot, recordings)
    if rows is None:
        return
    moments = moments_of(rows)
    found = check_order(moments) or check_labels(rows, moments) or check_gravity(rows, moments, recordings[0].effort_kind)
    if found is not None:
        yield found
