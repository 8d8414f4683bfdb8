"""The pieces that a session is chosen from: random motions of several kinds that start and end at one pose and keep every limit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.errors import NotSolvedError
from physident.excitation.design import Limits
from physident.excitation.limits.joint_limits import JointLimits, joint_margins
from physident.excitation.limits.limit import Margin
from physident.excitation.limits.workspace import Workspace
from physident.excitation.motion.motion import Motion
from physident.excitation.motion.point_to_point import PointToPoint
from physident.excitation.motion.trajectory import FREE_RANGE, Trajectory
from physident.robots.robot import Robot

Array = NDArray[np.float64]
PieceKind = Literal["fourier", "slow", "poses", "again"]
LENGTH = 15.0  # s of a piece: room for blocks of ten correlation lengths and for the filter's ends
SHARE = 0.9  # of a joint's first limit that a piece reaches before it is made smaller
SLOW = 0.06  # of the speed limit: friction below it is what static friction, hysteresis and breakaway act in
SHRINK = 0.75  # of its size, where a piece breaks a limit
SMALLEST = 0.02  # of its size, below which a piece is given up
SCREENED = 60  # instants at which a piece is tried before it is checked
HARMONICS = 5
HOMES = 60  # poses from which the home pose is chosen
POSES = 8  # at most, of a piece from pose to pose
DRAWS = 4  # motions from which a piece is taken
CYCLES = (1, 2, 3)  # periods of a Fourier piece


@dataclass(frozen=True, eq=False)
class Piece:
    """A motion of a kind that keeps every limit of the arm, ``loaded`` or not; ``margins`` are those to the limits. ``repeats`` is
    the earlier recording whose motion is recorded again."""

    kind: PieceKind
    motion: Motion
    loaded: bool
    margins: tuple[Margin, ...]
    repeats: str = ""


@dataclass(frozen=True, eq=False)
class Cell:
    """An arm where it stands: its ``robot``, the ``workspace`` of the bare arm (None: joint limits only), that of the arm with its
    load, and the pose ``home`` (n,) [rad|m] where every piece starts and ends."""

    robot: Robot
    workspace: Workspace | None
    loaded: Workspace | None
    home: Array

    def margins(self, motion: Motion, loaded: bool, count: int | None = None) -> list[Margin]:
        """Margins to every limit; of the workspace's on ``count`` instants, all of them by default."""
        workspace = self.loaded if loaded else self.workspace
        more = [] if workspace is None else workspace.margins(motion, *(() if count is None else (count,)))
        return [*joint_margins(self.robot, motion), *more]

    def keeps(self, motion: Motion, loaded: bool) -> tuple[Margin, ...] | None:
        """The margins of a motion that keeps every limit; None where it breaks one."""
        if any(one.margin <= 0 for one in self.margins(motion, loaded, SCREENED)):
            return None
        margins = tuple(self.margins(motion, loaded))
        return margins if all(one.margin > 0 for one in margins) else None


def cell_of(
    model: Model, heavy: Model | None, limits: Limits, table: float | None, clearance: float, meshes: object, seed: int
) -> Cell:
    """The cell of an arm, and of ``heavy``, the arm with its load; raises NotSolvedError where no pose keeps the limits."""
    joints = JointLimits.of(model.robot)
    joints.check_movable()
    if limits == "joint":
        return Cell(model.robot, None, None, _middle(joints))
    workspace, loaded = (None if m is None else Workspace.of(m, table, clearance, meshes) for m in (model, heavy))  # pyright: ignore[reportArgumentType]
    assert workspace is not None
    return Cell(model.robot, workspace, loaded, _home(model.robot, loaded or workspace, joints, seed))


def make_pieces(cell: Cell, count: int, loaded: bool, seed: int) -> list[Piece]:
    """``count`` pieces that keep every limit: two thirds Fourier series of one to three periods, the rest slow series with many
    reversals and moves from pose to pose with pauses."""
    kinds: tuple[PieceKind, ...] = ("fourier", "slow", "fourier", "poses", "fourier", "fourier")
    rng = np.random.default_rng(seed)
    pieces = []
    for k in range(2 * count):
        if len(pieces) == count:
            break
        kind = kinds[k % len(kinds)]
        piece = _fitted(cell, kind, CYCLES[k % len(CYCLES)], loaded, rng)
        pieces += [] if piece is None else [piece]
    return pieces


def _fitted(cell: Cell, kind: PieceKind, cycles: int, loaded: bool, rng: np.random.Generator) -> Piece | None:
    """Of several random motions, each made smaller until it keeps every limit, the one that moves the most."""
    best, most = None, 0.0
    for _ in range(DRAWS):
        largest = _poses(cell, rng) if kind == "poses" else _series(cell, SLOW if kind == "slow" else 1.0, cycles, rng)
        motion = _within(cell, largest, loaded)
        if motion is not None and (moved := _moved(cell, motion)) > most:
            best, most = motion, moved
    while best is not None:
        margins = cell.keeps(best, loaded)
        if margins is not None:
            return Piece(kind, best, loaded, margins)
        best = _sized(best, cell.home, SHRINK) if _moved(cell, best) > SMALLEST * most else None
    return None


def _within(cell: Cell, largest: Trajectory | PointToPoint, loaded: bool) -> Trajectory | PointToPoint | None:
    """A motion made smaller until it keeps every limit at some instants; None where it would hardly move."""
    size = 1.0
    while size > SMALLEST:
        motion = _sized(largest, cell.home, size)
        if all(one.margin > 0 for one in cell.margins(motion, loaded, SCREENED)):
            return motion
        size *= SHRINK
    return None


def _moved(cell: Cell, motion: Motion) -> float:
    """How far a motion goes: its ranges as shares of what each joint could, as a mean."""
    limits, extent = JointLimits.of(cell.robot), motion.extent()
    return float(np.mean((extent.upper - extent.lower) / np.minimum(limits.upper - limits.lower, 2 * FREE_RANGE)))


def _sized(motion: Trajectory | PointToPoint, home: Array, size: float) -> Trajectory | PointToPoint:
    """A motion about home made smaller; a series keeps its time, moves keep their speed at most."""
    if isinstance(motion, Trajectory):
        return replace(motion, a=size * motion.a, b=size * motion.b, q0=home + size * (motion.q0 - home))
    return replace(
        motion, points=home + size * (motion.points - home), speed=size * motion.speed,
        acceleration=size * motion.acceleration,
    )  # fmt: skip


def _series(cell: Cell, speed: float, cycles: int, rng: np.random.Generator) -> Trajectory:
    """A random Fourier series from home to home, each joint of which reaches its first limit; ``speed`` is a share of the limit."""
    limits, home = JointLimits.of(cell.robot), cell.home
    order = np.arange(1, HARMONICS + 1)
    a, b = rng.standard_normal((2, cell.robot.n, HARMONICS)) / order
    frequency = cycles / LENGTH
    shape = Trajectory(a, b, np.zeros(cell.robot.n), frequency, LENGTH).to_rest()
    shape = replace(shape, q0=shape.b.sum(axis=1))  # it starts at zero
    extent = shape.extent()
    reach = np.minimum(limits.upper - home, FREE_RANGE), np.minimum(home - limits.lower, FREE_RANGE)
    ways = [
        reach[0] / np.maximum(extent.upper, 1e-12),
        reach[1] / np.maximum(-extent.lower, 1e-12),
        speed * limits.speed / extent.speed,
        limits.acceleration / extent.acceleration,
    ]
    factor = SHARE * np.minimum.reduce(ways)
    return replace(shape, a=factor[:, None] * shape.a, b=factor[:, None] * shape.b, q0=home + factor * shape.q0)


def _poses(cell: Cell, rng: np.random.Generator) -> PointToPoint:
    """Moves from home over random poses and back, with pauses, as many as fit into the length of a piece."""
    limits, home = JointLimits.of(cell.robot), cell.home
    lower, upper = np.maximum(limits.lower, home - FREE_RANGE), np.minimum(limits.upper, home + FREE_RANGE)
    targets = home + SHARE * (rng.uniform(lower, upper, (POSES, cell.robot.n)) - home)
    speed, acceleration = SHARE * float(limits.speed.min()), SHARE * float(limits.acceleration.min())
    while True:
        for count in range(POSES, 0, -1):
            moves = PointToPoint(np.vstack([home, targets[:count], home]), speed, acceleration, pause=0.6)
            if moves.duration <= LENGTH:
                return moves
        targets = home + SHRINK * (targets - home)  # an arm too slow to go so far and back


def _middle(limits: JointLimits) -> Array:
    """The pose nearest to zero that leaves room to both sides."""
    quarter = (limits.upper - limits.lower) / 4
    return np.clip(0.0, limits.lower + quarter, limits.upper - quarter)


def _home(robot: Robot, workspace: Workspace, limits: JointLimits, seed: int) -> Array:
    """Of random poses, the one whose smallest margin, in units of its limit or of the arm's reach, is the largest."""
    rng = np.random.default_rng(seed)
    middle, half = (limits.upper + limits.lower) / 2, np.minimum((limits.upper - limits.lower) / 2, FREE_RANGE)
    centre = np.where(half < FREE_RANGE, middle, np.clip(0.0, limits.lower + half, limits.upper - half))
    poses = np.vstack([_middle(limits), centre + 0.6 * half * rng.uniform(-1, 1, (HOMES, robot.n))])
    best, most = None, 0.0
    for pose in poses:
        margins = workspace.margins(_at_rest(pose), 2)
        least = min(one.margin / (one.allowed if one.unit.startswith("N") else 1.0) for one in margins)
        if least > most:
            best, most = pose, least
    if best is None:
        raise NotSolvedError(
            f"none of {len(poses)} random poses keeps every limit; expected another table height or clearance, or --limits joint"
        )
    return best


def _at_rest(pose: Array) -> Trajectory:
    """Standing still at a pose."""
    none = np.zeros((len(pose), 2))
    return Trajectory(none, none, pose, 1.0, 1.0)
