"""Joints that are recorded at one exact position while their effort is that of a joint in motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physident.recordings.recording import Recording
from physident.setup_checks.finding import SetupFinding, joint_list
from physident.setup_checks.joint_fit import Moments, own_unexplained
from physident.setup_checks.rows import Rows, with_unit_gains

TRAVELLED = 0.1  # rad|m: the integral of a velocity's noise goes nowhere near as far
MOSTLY = 0.5  # of the effort's variance: noise is faster, and what a held joint carries follows the description


def check_frozen(recordings: Sequence[Recording]) -> SetupFinding | None:
    """Joints whose position is the same in every row, although by their velocity they travel."""
    constant = np.all([np.ptp(recording.q, axis=0) == 0 for recording in recordings], axis=0)
    travelled = np.zeros(len(constant))
    for recording in recordings:
        if recording.dq is not None:
            steps = np.diff(recording.time)[:, None] * (recording.dq - recording.dq.mean(axis=0))[1:]
            travelled = np.maximum(travelled, np.ptp(np.cumsum(steps, axis=0), axis=0))
    frozen = np.flatnonzero(constant & (travelled > TRAVELLED))
    if not len(frozen):
        return None
    joints, j = tuple(int(j) + 1 for j in frozen), frozen[0]
    return SetupFinding(
        kind="position_frozen",
        joints=joints,
        statement=f"the position of {joint_list(joints)} is the same in every row, but by its velocity it moves: its encoder is frozen, or the column"
        " is not its position",
        evidence=f"joint {j + 1} stands at {recordings[0].q[0, j]:.4g}, and its velocity goes back and forth over {travelled[j]:.3g}, in rad or m",
        void=True,
    )


def check_still(rows: Rows, moments: Moments, recordings: Sequence[Recording]) -> SetupFinding | None:
    """Joints whose position is the same in every row, although most of their effort's variance is slow and nothing that the
    description asks of a joint at rest."""
    constant = np.all([np.ptp(recording.q, axis=0) == 0 for recording in recordings], axis=0)
    if not constant.any() or constant.all():
        return None
    efforts = [with_unit_gains(recording).torque for recording in recordings]
    whole = np.concatenate([effort - effort.mean(axis=0) for effort in efforts]).var(axis=0)
    slow = own_unexplained(moments) * np.mean(rows.centred(rows.torque) ** 2, axis=0)
    frozen = np.flatnonzero(constant & (slow > MOSTLY * whole))
    if not len(frozen):
        return None
    joints = tuple(int(j) + 1 for j in frozen)
    j = frozen[0]
    share = 100 * slow[j] / whole[j]
    return SetupFinding(
        kind="position_frozen",
        joints=joints,
        statement=f"the position of {joint_list(joints)} is the same in every row, but its effort is not that of a joint at rest:"
        " its encoder is frozen, or the column is not its position",
        evidence=f"joint {j + 1} stands at {recordings[0].q[0, j]:.4g} {rows.robot.joints[j].unit('rad')}, and {share:.0f} % of its effort's variance is no weight,"
        " no inertia and no noise",
        void=True,
    )
