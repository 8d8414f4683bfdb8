"""Plan a session: of pieces that keep every limit, those that answer most of what is open within some minutes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.payload import Payload
from physident.errors import InputError, NotSolvedError
from physident.excitation.design import Limits
from physident.excitation.detectability import Noise
from physident.excitation.limits.workspace import CLEARANCE
from physident.excitation.session.choice import choose
from physident.excitation.session.evidence import Evidence, Shown
from physident.excitation.session.outlook import expectations_of, piece_purpose, worse_without
from physident.excitation.session.pieces import LENGTH, Piece, cell_of, make_pieces
from physident.excitation.session.questions import OpenQuestion, RangeQuestion
from physident.excitation.session.ranges import Ranges, covered, open_ranges, ranges_of
from physident.excitation.session.session import Leg, Outlook, Session

Array = NDArray[np.float64]
SHORTEST = 3 * LENGTH  # s: two pieces to fit and one to hold out
WITH_WARM_UP = 120.0  # s: from here on a session has time for a warm-up and for a repeat
POOL = 18  # pieces to choose from, and as many again with a load
SMALLEST_POOL, LARGEST_POOL = 4, 200


@dataclass(frozen=True, kw_only=True)
class Budget:
    """The time and the limits of a session: ``minutes``, ``load`` [kg] at the tool in loaded pieces, or None; the rest as for
    ``design_trajectory``. ``pool`` is the number of pieces to choose from."""

    minutes: float = 3.0
    load: float | None = None
    limits: Limits = "all"
    table: float | None = 0.0
    clearance: float = CLEARANCE
    meshes: str | Path | None = None
    seed: int = 0
    pool: int = POOL

    def __post_init__(self) -> None:
        if not (np.isfinite(self.minutes) and SHORTEST / 60 <= self.minutes <= 60):
            raise InputError(
                f"minutes is {self.minutes:g}, expected {SHORTEST / 60:g} to 60: two pieces of {LENGTH:g} s to fit and one to hold out"
            )
        if not SMALLEST_POOL <= self.pool <= LARGEST_POOL:
            raise InputError(f"pool is {self.pool}, expected {SMALLEST_POOL} to {LARGEST_POOL} motions to choose from")
        if self.load is not None and not (np.isfinite(self.load) and self.load > 0):
            raise InputError(f"load is {self.load:g} kg, expected a positive mass, or None for no load")


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A piece, what it shows of the questions, and its ranges."""

    piece: Piece
    shown: Shown
    ranges: Ranges


def plan_session(
    model: Model,
    questions: Sequence[OpenQuestion],
    noise: Noise,
    budget: Budget,
    shown_ranges: Ranges | None = None,
    noise_words: str = "",
    notes: Sequence[str] = (),
    progress: Callable[[float], None] = lambda _: None,
) -> Session:
    """The session that within its minutes does most for all questions at once, and what it is expected to settle.

    Every kind of question weighs alike. A question that is as good as settled attracts no more minutes. ``shown_ranges`` are those of
    earlier recordings. Raises InputError for a budget that cannot be used, NotSolvedError where too few motions keep the limits.
    """
    heavy = None if budget.load is None else with_load(model, budget.load)
    cell = cell_of(model, heavy, budget.limits, budget.table, budget.clearance, budget.meshes, budget.seed)
    evidence = Evidence(model, heavy, noise, questions)
    pieces = make_pieces(cell, budget.pool, False, budget.seed + 1)
    pieces += [] if heavy is None else make_pieces(cell, budget.pool, True, budget.seed + 2)
    if len([p for p in pieces if not p.loaded]) < 3:
        raise NotSolvedError(
            "fewer than three motions within the limits were found; expected wider limits, another --table, or --limits joint"
        )
    candidates = []
    for k, piece in enumerate(pieces):
        candidates.append(_Candidate(piece, evidence.shown(piece.motion, piece.loaded), ranges_of(model, piece.motion)))
        progress((k + 1) / (len(pieces) + 2))
    possible = reduce(Ranges.joined, (one.ranges for one in candidates))
    evidence.sized_by(reduce(Shown.__add__, (one.shown for one in candidates)))
    ranges = open_ranges(shown_ranges, possible)
    score = _Score(evidence, ranges, shown_ranges, possible, budget.minutes)
    chosen, holdout = _chosen(candidates, budget, score, heavy is not None)
    progress(1.0)
    return _session(chosen, holdout, budget, score, noise_words, (*notes, *_load_notes(heavy, chosen)))


class _Score:
    """How much of everything open some candidates settle together, from 0 to 1."""

    def __init__(
        self,
        evidence: Evidence,
        ranges: Sequence[RangeQuestion],
        shown: Ranges | None,
        possible: Ranges,
        minutes: float,
    ) -> None:
        self.evidence, self.ranges, self.earlier, self.possible = evidence, tuple(ranges), shown, possible
        expected = minutes * 60 * evidence.noise.worth
        self.needed = evidence.needed(expected)
        kinds = [*(one.kind for one in evidence.questions), *("range" for _ in self.ranges)]
        self.weights = np.array([1 / (len(set(kinds)) * kinds.count(kind)) for kind in kinds])

    def shown(self, chosen: Sequence[_Candidate]) -> Shown:
        """What some candidates show together."""
        p = len(self.evidence.questions) and len(chosen)
        if not p:
            n = self.evidence.model.robot.n
            size = sum(len(e.columns(self.evidence.model.robot)) for e in self.evidence.effects)
            return Shown(np.zeros((size, size)), np.zeros(n))
        return reduce(Shown.__add__, (one.shown for one in chosen))

    def joined(self, chosen: Sequence[_Candidate]) -> Ranges | None:
        """The ranges of some candidates and of earlier recordings."""
        every = [*(one.ranges for one in chosen), *([] if self.earlier is None else [self.earlier])]
        return reduce(Ranges.joined, every) if every else None

    def shares(self, chosen: Sequence[_Candidate]) -> Array:
        """For each question and range, the share of what would settle it."""
        found = self.evidence.noncentralities(self.shown(chosen)) if len(self.needed) else np.zeros(0)
        return np.append(np.minimum(found / self.needed, 1.0), covered(self.ranges, self.joined(chosen), self.possible))

    def __call__(self, chosen: Sequence[_Candidate]) -> float:
        return float(self.weights @ self.shares(chosen)) if len(self.weights) else 0.0


def _chosen(
    candidates: list[_Candidate], budget: Budget, score: _Score, loaded: bool
) -> tuple[list[_Candidate], _Candidate]:
    """The candidates to fit, and the one to hold out: of the Fourier pieces, the one that moves most."""
    free = [one for one in candidates if not one.piece.loaded and one.piece.kind == "fourier"] or candidates
    holdout = max(free, key=lambda one: float(np.mean(one.ranges.size / np.maximum(score.possible.size, 1e-12))))
    rest = [one for one in candidates if one is not holdout]
    seconds = [one.piece.motion.duration for one in rest]
    spare = budget.minutes * 60 - holdout.piece.motion.duration
    spare -= 2 * LENGTH if budget.minutes * 60 >= WITH_WARM_UP else 0.0
    start = (
        [next(i for i, one in enumerate(rest) if one.piece.loaded)]
        if loaded and any(o.piece.loaded for o in rest)
        else []
    )
    if loaded and not start:
        raise NotSolvedError(f"no motion with {budget.load:g} kg keeps every limit; expected a lighter load")
    picked = choose(rest, seconds, spare, score, start)
    if not picked:  # nothing is open: still the most moving pieces, so that there is something to fit
        picked = list(range(min(len(rest), max(1, int(spare // LENGTH)))))
    return [rest[i] for i in picked], holdout


def _session(
    chosen: list[_Candidate],
    holdout: _Candidate,
    budget: Budget,
    score: _Score,
    noise_words: str,
    notes: tuple[str, ...],
) -> Session:
    """The legs in the order to record them: without the load first, so that it is attached once."""
    chosen = sorted(chosen, key=lambda one: one.piece.loaded)
    long = budget.minutes * 60 >= WITH_WARM_UP
    names = [f"{k:02d}_{one.piece.kind}{'_loaded' if one.piece.loaded else ''}" for k, one in enumerate(chosen, 1)]
    legs = []
    for name, one in zip(names, chosen, strict=True):
        settles = worse_without(score.evidence, score.shown(chosen), one.shown)
        legs.append(_leg(name, one.piece, piece_purpose(one.piece), settles))
    unloaded = [k for k, one in enumerate(chosen) if not one.piece.loaded]
    fourier = [k for k in unloaded if chosen[k].piece.kind == "fourier"] or unloaded
    last = _leg(
        f"{len(chosen) + 1:02d}_validation", holdout.piece, "validation: nothing is fitted to it", (), holdout=True
    )
    if not (long and fourier):
        place = len(unloaded)
        legs.insert(place, last)
    else:
        first = chosen[fourier[0]]
        warm = _leg("00_warm_up", first.piece, "warms gears and grease; not fitted", (), warm_up=True)
        repeat = _leg(
            f"{len(chosen) + 2:02d}_repeat", first.piece,
            f"repeats {names[fourier[0]]}: what differs is the noise floor and the drift", (),
        )  # fmt: skip
        legs = [warm, *legs[: len(unloaded)], last, repeat, *legs[len(unloaded) :]]
        chosen = [*chosen, first]
    outlook = Outlook(
        expectations=expectations_of(
            score.evidence, score.shown(chosen), score.ranges, score.joined(chosen), score.possible
        ),
        curve=_curve(chosen, score),
        load=budget.load,
        noise=noise_words,
        notes=notes,
    )
    return Session(tuple(legs), (), outlook)


def _leg(
    name: str, piece: Piece, purpose: str, settles: tuple[str, ...], *, holdout: bool = False, warm_up: bool = False
) -> Leg:
    return Leg(name, piece.motion, 1.0, piece.loaded, holdout, warm_up, purpose, settles)


def _curve(chosen: list[_Candidate], score: _Score) -> tuple[tuple[float, float], ...]:
    """Minutes of fitted motion, and how many questions are expected to be settled by then."""
    minutes, result = 0.0, [(0.0, 0.0)]
    for k, one in enumerate(chosen, 1):
        minutes += one.piece.motion.duration / 60
        part = chosen[:k]
        expected = expectations_of(score.evidence, score.shown(part), score.ranges, score.joined(part), score.possible)
        result.append((minutes, float(sum(e.settled for e in expected))))
    return tuple(result)


def _load_notes(heavy: Model | None, chosen: Sequence[_Candidate]) -> tuple[str, ...]:
    loaded = sum(one.piece.loaded for one in chosen)
    return () if heavy is None else (f"{loaded} pieces carry the load; fix it to the tool before them, once",)


def with_load(model: Model, load: float) -> Model:
    """The model with a point mass [kg] at the tool."""
    x, y, z = model.robot.tool
    body = load * np.array([1, x, y, z, y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y])
    names = [effect.name for effect in model.effects]
    if Payload.name not in names:
        return Model(model.robot, (*model.effects, Payload()), np.concatenate([model.theta, body]))
    parts = [theta + body if e.name == Payload.name else theta for e, theta in model.effect_parameters()]
    return replace(model, theta=np.concatenate(parts))
