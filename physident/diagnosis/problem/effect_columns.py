"""The columns of one effect alone on rows that are known: a regressor without its torque, its times and its other effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.columns import Columns
from physident.dynamics.column_structure import ColumnStructure, KeptRows
from physident.dynamics.regressor import with_transition
from physident.effects.effect import Effect
from physident.large_arrays import empty, is_shared
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]


def effect_columns(
    robot: Robot,
    effect: Effect,
    signals: Sequence[Signals],
    kept: Sequence[Sequence[KeptRows]],
    filter: Filter,
    scale: Array,
) -> Columns:
    """An effect's filtered columns (M, k) in the ``kept`` rows of each recording's segments, every row times ``scale`` (M, n)."""
    structure = ColumnStructure.of(robot, [effect])
    counts = [len(columns) for columns in structure.columns]
    together = empty((sum(counts), len(scale)), shared=any(is_shared(one.v) for one in signals))
    values = np.split(together, np.cumsum(counts)[:-1])
    first = 0
    for one, pieces in zip(signals, kept, strict=True):
        turned = with_transition(robot, [effect], one)
        for piece in pieces:
            if not len(piece.rows):
                continue
            part, rows = turned.part(piece.samples), slice(first, first + len(piece.rows))
            structure.fill(values, first, part, piece.rows, filter)
            counted = structure.counted(part, piece.rows, filter) if effect.unsettled(robot, part) is not None else None
            for j, own in enumerate(values):
                own[:, rows] *= scale[rows, j] if counted is None else scale[rows, j] * counted[:, j]
            first = rows.stop
    joints = tuple((columns, own.T) for columns, own in zip(structure.columns, values, strict=True))
    return Columns(len(effect.columns(robot)), len(scale), joints)
