"""Which effects recordings can show, on which joint, before anything is diagnosed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import build_regressor
from physident.effects.catalogue import CATALOGUE, DEFAULT_EFFECTS, make_effects, on_joints
from physident.effects.classification import Detection
from physident.effects.effect import Effect
from physident.identifiability.projection import Baseline
from physident.identifiability.visibility import VISIBLE
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot
from physident.threads import one_thread

Array = NDArray[np.float64]
ZERO = 1e-6  # of the effect's largest column: a smaller column is rounding


@dataclass(frozen=True)
class Cell:
    """One effect on some joints (empty: the whole arm).

    ``new`` and ``refitted`` are shares of the energy of its columns, 0 where nothing is visible: with a fixed baseline, as
    for recordings that a model was not fitted to, and with a baseline that is refitted. ``cutoff`` [Hz] that the effect
    needs, 0 for any.
    """

    effect: str
    joints: tuple[int, ...]
    new: float
    refitted: float
    cutoff: float


@dataclass(frozen=True, eq=False)
class Identifiability:
    """The table of cells for a robot and recordings, with the filter's ``cutoff`` [Hz]."""

    cells: tuple[Cell, ...]
    joints: int
    cutoff: float

    def share(self, effect: str, joints: tuple[int, ...], question: str) -> float:
        """The share for one effect and its joints; ``question`` is "new" or "refitted"."""
        (cell,) = [c for c in self.cells if c.effect == effect and c.joints == joints]
        return cell.new if question == "new" else cell.refitted

    def as_dict(self) -> dict[str, Any]:
        """The table for JSON."""
        return {
            "cutoff_Hz": self.cutoff,
            "cells": [asdict(cell) | {"joints": list(cell.joints)} for cell in self.cells],
        }

    def __repr__(self) -> str:
        return "\n".join(_text(self))


@one_thread
def measure_identifiability(
    robot: Robot, signals: Sequence[Signals], filter: Filter, baseline: Sequence[Effect] | None = None
) -> Identifiability:
    """For every effect of the catalogue and every joint, the share of its columns that a baseline cannot reproduce.

    The ``baseline`` is the five default effects unless given; an effect that it contains is compared with its others. Each
    joint's torque counts alike. Shape parameters are in the middle of their grids.
    """
    effects = tuple(make_effects(DEFAULT_EFFECTS) if baseline is None else baseline)
    model = Model.nominal(robot, effects)
    signals = [model.refer(one) for one in signals]
    whole = build_regressor(robot, effects, signals, filter)
    size = np.sqrt((whole.torque**2).mean(axis=0))
    weights = 1 / np.where(size > 0, size, 1.0)
    whole_model = Baseline.of(whole, weights)
    cells = []
    for name, cls in CATALOGUE.items():
        if cls.detection is Detection.NEVER:
            continue
        row = []
        recorded = not cls.needs_temperature or all(one.temperature is not None for one in signals)
        recorded &= not (cls.needs_torque_sensor and any(one.from_currents for one in signals))
        for joints in cls.places(robot):
            if not recorded:
                row.append((joints, 0.0, 0.0, 0.0))
                continue
            candidate = cls.at_grid_middle(robot, joints or None)
            fitted = whole_model
            if any(effect.name == name for effect in effects):
                others = _without(effects, name, joints, robot)
                fitted = Baseline.of(build_regressor(robot, others, signals, filter), weights)
            projection = fitted.project(build_regressor(robot, [candidate], signals, filter, model=model))
            needed = max((candidate.cutoff_needed(robot, one) for one in signals), default=0.0)
            row.append((joints, float(np.sqrt(np.trace(projection.gram))), projection.share, needed))
        largest = max((norm for _, norm, _, _ in row), default=0.0)  # no row: neighbours of an arm of one joint
        for joints, norm, share, needed in row:
            shown = norm > ZERO * largest > 0
            cells.append(Cell(name, joints, float(shown), share if shown else 0.0, needed))
    return Identifiability(tuple(cells), robot.n, filter.cutoff)


def _without(effects: tuple[Effect, ...], name: str, joints: tuple[int, ...], robot: Robot) -> list[Effect]:
    """The effects with one of them taken off some joints."""
    rest = []
    for effect in effects:
        if effect.name == name:
            left = tuple(j for j in (effect.joints or tuple(range(1, robot.n + 1))) if j not in joints)
            if not left or not joints:
                continue
            effect = on_joints(effect, robot, left)
        rest.append(effect)
    return rest


def _text(table: Identifiability) -> list[str]:
    more = "   needs" if any(c.cutoff > table.cutoff for c in table.cells) else ""
    rows = [f"{'effect':<28}" + "".join(f"{'J' + str(j):>8}" for j in range(1, table.joints + 1)) + more]
    for name in dict.fromkeys(c.effect for c in table.cells):
        row = [c for c in table.cells if c.effect == name]
        at = {(c.joints or (1,))[0]: _cell(c) for c in row}
        cells = "".join(at.get(j, " " * 8) for j in range(1, table.joints + 1))
        needed = max(c.cutoff for c in row)
        band = f"{needed:.1f} Hz" if needed > table.cutoff else ""
        rows.append(f"{name:<28}{cells:<{8 * table.joints}}   {band}".rstrip())
    rows.append(
        "share of its torque that a refitted baseline cannot reproduce; . none: it cannot be distinguished from the baseline,"
    )
    rows.append(
        "unless the baseline is fixed (recordings that the model was not fitted to); o no torque at all: it cannot be seen"
    )
    hidden = sum(c.refitted < VISIBLE for c in table.cells)
    never = sum(c.new == 0 for c in table.cells)
    rows.append(
        f"verdict: of {len(table.cells)} cells {never} show nothing and {hidden - never} more cannot be distinguished from the baseline"
    )
    return rows


def _cell(cell: Cell) -> str:
    if cell.new == 0:
        return "       o"
    return "       ." if cell.refitted < VISIBLE else f"{cell.refitted:8.2g}"
