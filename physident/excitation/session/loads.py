"""Pieces with a load that was weighed: they separate mass from drive gains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.inertia import Payload
from physident.errors import NotSolvedError
from physident.excitation.detectability import Noise
from physident.excitation.session.pieces import LENGTH, Cell, Piece, make_pieces
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
POOL = 6  # loaded pieces to choose from
EVERY = 120.0  # s of a session, for which there is one loaded piece
HALF = 196.0  # %: half of a 95 % interval of a standard error
RATE = 50.0  # Hz
UNSEEN = 100.0  # %: a gain that is not known to a factor of two was not shown


@dataclass(frozen=True, eq=False)
class LoadedPieces:
    """The loaded ``pieces`` of a session, and a ``note`` of what they will tell."""

    pieces: tuple[Piece, ...]
    note: str

    @property
    def duration(self) -> float:
        """Their time in motion [s]."""
        return sum(one.motion.duration for one in self.pieces)


def with_load(model: Model, load: float) -> Model:
    """The model with a point mass [kg] at the tool."""
    x, y, z = model.robot.tool
    body = load * np.array([1, x, y, z, y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y])
    if Payload.name not in [effect.name for effect in model.effects]:
        return Model(model.robot, (*model.effects, Payload()), np.concatenate([model.theta, body]))
    parts = [theta + body if e.name == Payload.name else theta for e, theta in model.effect_parameters()]
    return replace(model, theta=np.concatenate(parts))


def loaded_pieces(model: Model, heavy: Model, cell: Cell, noise: Noise, minutes: float, seed: int) -> LoadedPieces:
    """One piece for every two minutes, along which the load shows most in units of the noise.

    Raises NotSolvedError where no motion with the load keeps every limit.
    """
    pool = make_pieces(cell, POOL, True, seed)
    if not pool:
        raise NotSolvedError("no motion with the load keeps every limit; expected a lighter load")
    shown = [_shown(model, heavy, noise, one) for one in pool]
    order = np.argsort([-float(np.log1p(one).sum()) for one in shown])[: max(1, int(minutes * 60 / EVERY))]
    total = np.sum([shown[k] for k in order], axis=0)
    return LoadedPieces(tuple(pool[k] for k in order), _note(total, len(order)))


def _shown(model: Model, heavy: Model, noise: Noise, piece: Piece) -> Array:
    """Energy (n,) of the load's torque along a piece, in units of the noise and its independent samples."""
    states = piece.motion.states(np.arange(0.0, LENGTH, 1 / RATE))
    signals = Signals(states.time, states.q, states.v, states.a, rate=RATE, source="a planned motion")
    torque = (heavy.torque(signals) - model.torque(signals)) / noise.sigma
    return (torque**2).sum(axis=0) * np.minimum(noise.worth / RATE, 1.0)


def _note(energy: Sequence[float] | Array, count: int) -> str:
    """What the loaded pieces tell of each joint's gain, and the command that says it."""
    half = HALF / np.sqrt(np.maximum(energy, 1e-12))
    told = [f"{j} to {h:.0f} %" if h < UNSEEN else f"{j} not" for j, h in enumerate(half.tolist(), 1)]
    pieces = "1 piece carries" if count == 1 else f"{count} pieces carry"
    return (
        f"{pieces} the load; fix it to the tool before, once; physident drive-gains --unloaded ... --loaded ... --load-mass KG then"
        f" tells the drive gains, at best that of joint {', '.join(told)}"
    )
