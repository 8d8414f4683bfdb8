"""Pieces that repeat the motions of earlier recordings: what a model lacks is in both, so that their difference shows a change alone."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from physident.excitation.motion.recorded import RecordedMotion
from physident.excitation.session.pieces import LENGTH, Cell, Piece
from physident.recordings.signals import Signals


def repeated_pieces(cell: Cell, earlier: Sequence[Signals], seconds: float) -> tuple[list[Piece], list[str]]:
    """The motions of earlier recordings as pieces that last at most so many ``seconds`` together, those that move most first, the last
    one cut where the time ends; and notes on those that break a limit.

    An acceleration counts where a limit is stated: the arm has made these motions before.
    """
    pieces: list[Piece] = []
    notes: list[str] = []
    for one in sorted(earlier, key=lambda one: -float(np.mean(np.ptp(one.q, axis=0)))):
        left = seconds - sum(piece.motion.duration for piece in pieces)
        if left < LENGTH:
            break
        name, motion = Path(one.source).name, RecordedMotion.of_signals(one, left)
        if motion is None:
            continue
        margins = () if cell.workspace is None else tuple(cell.workspace.margins(motion))
        broken = [f"{m.limit} of {m.where} would be {m.reached:.3g} {m.unit}" for m in margins if m.margin <= 0]
        broken += motion.violations(cell.robot)
        if broken:
            notes.append(f"the motion of {name} is not repeated: {broken[0]}")
        else:
            pieces.append(Piece("again", motion, False, margins, name))
    return pieces, notes
