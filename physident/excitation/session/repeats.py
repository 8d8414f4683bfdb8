"""Pieces that repeat the motions of earlier recordings: what a model lacks is in both, so that their difference shows a change alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from physident.errors import InputError
from physident.excitation.motion.recorded import SHORTEST_REPEAT, RecordedMotion
from physident.excitation.session.pieces import LENGTH, Cell, Piece
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

OVERSHOOT = 0.01  # of a motion's range: a controller and an encoder go so far beyond what was planned
MADE = 0.05  # of a speed or an acceleration, which a recording shows with noise


def repeated_pieces(cell: Cell, earlier: Sequence[Signals], seconds: float) -> tuple[list[Piece], list[str]]:
    """The motions of earlier recordings as pieces that last at most so many ``seconds`` together, those that move most first, the last
    one cut where the time ends; and notes on those that are left out: they could not be compared, break a limit by more than a controller
    overshoots, or have no time left. Raises InputError for recordings of another number of joints.
    """
    pieces: list[Piece] = []
    notes: list[str] = []
    for one in sorted(earlier, key=lambda one: -float(np.mean(np.ptp(one.q, axis=0)))):
        if one.q.shape[1] != cell.robot.n:
            raise InputError(
                f"{one.source} has {one.q.shape[1]} joints, but robot {cell.robot.name} has {cell.robot.n}; expected the"
                " recordings and the model of this robot"
            )
        left = seconds - sum(piece.motion.duration for piece in pieces)
        name, motion = (
            Path(one.source).name,
            RecordedMotion.of_signals(one, left, cell.robot) if left >= LENGTH else None,
        )
        if why := _not_comparable(one) or ("no time is left in this session" if left < LENGTH else ""):
            notes.append(f"the motion of {name} is not repeated: {why}")
            continue
        if motion is None:
            continue
        motion = _inside(motion, cell.robot)
        margins = () if cell.workspace is None else tuple(cell.workspace.margins(motion))
        broken = _broken(motion, cell.robot)
        broken += [f"{m.limit} of {m.where} would be {m.reached:.3g} {m.unit}" for m in margins if m.margin <= 0]
        if broken:
            notes.append(f"the motion of {name} is not repeated: {broken[0]}")
        else:
            pieces.append(Piece("again", motion, False, margins, name))
    return pieces, notes


def _not_comparable(one: Signals) -> str:
    """Why a recording could not be compared with its repetition; empty where it could."""
    if len(one.starts) > 1:
        return "it has gaps, and only recordings without any are compared"
    if one.moving is None or one.moving[1] - one.moving[0] < SHORTEST_REPEAT:
        return f"it moves for less than the {SHORTEST_REPEAT:g} s that are compared"
    return ""


def _inside(motion: RecordedMotion, robot: Robot) -> RecordedMotion:
    """The motion with what overshoots a position limit by a little brought back to it."""
    points = np.clip(motion.points, robot.lower, robot.upper)
    small = np.abs(points - motion.points).max() <= OVERSHOOT * float(np.ptp(motion.points, axis=0).max())
    return replace(motion, points=points) if small else motion


def _broken(motion: RecordedMotion, robot: Robot) -> list[str]:
    """The limits that a motion breaks by more than an overshoot, in words."""
    extent, n = motion.extent(), robot.n
    room = OVERSHOOT * np.maximum(extent.upper - extent.lower, 1e-9)
    fastest = np.array(robot.acceleration_limit or (np.inf,) * n)
    broken = []
    for j in range(n):
        low, high = extent.lower[j], extent.upper[j]
        if low < robot.lower[j] - room[j] or high > robot.upper[j] + room[j]:
            broken.append(
                f"joint {j + 1} went from {low:.3g} to {high:.3g}, allowed is {robot.lower[j]:.3g} to {robot.upper[j]:.3g}"
            )
        for name, reached, limit in (
            ("a speed", extent.speed[j], robot.velocity_limit[j]),
            ("an acceleration", extent.acceleration[j], fastest[j]),
        ):
            if reached > (1 + MADE) * limit:
                broken.append(f"joint {j + 1} reached {name} of {reached:.3g}, allowed is {limit:.3g}")
    return broken
