"""Plan a session: of pieces that keep every limit, those that answer most of what is open within some minutes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.errors import InputError, NotSolvedError
from physident.excitation.design import Limits
from physident.excitation.detectability import Noise
from physident.excitation.limits.workspace import CLEARANCE
from physident.excitation.session.choice import choose
from physident.excitation.session.evidence import Evidence, Shown
from physident.excitation.session.loads import LoadedPieces, loaded_pieces, with_load
from physident.excitation.session.outlook import expectations_of, piece_purpose, worse_without
from physident.excitation.session.outlook_text import hidden_text
from physident.excitation.session.pieces import LENGTH, Piece, cell_of, make_pieces
from physident.excitation.session.questions import OpenQuestion, RangeQuestion
from physident.excitation.session.ranges import Ranges, covered, open_ranges, ranges_of
from physident.excitation.session.repeats import repeated_pieces
from physident.excitation.session.session import Leg, Outlook, Session
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
SHORTEST = 3 * LENGTH  # s: the fewest pieces to fit and one to hold out
LONGEST = 60.0  # min
FEWEST = 2  # pieces to fit
SAME = 1e-6  # s: rounding of a duration
WITH_WARM_UP = 120.0  # s: from here on a session has time for a warm-up and for a repeat
POOL = 18  # pieces to choose from, and as many again with a load
ANY_CHANGE = "what has changed stands out of the noise of two recordings there, whatever the model lacks; it is no question of this list"
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
        shortest = (SHORTEST + (0.0 if self.load is None else LENGTH)) / 60
        if not (np.isfinite(self.minutes) and shortest <= self.minutes <= LONGEST):
            more = "" if self.load is None else ", and one with the load"
            raise InputError(
                f"minutes is {self.minutes:g}, expected {shortest:g} to {LONGEST:g}: two pieces of {LENGTH:g} s to fit and one to hold"
                f" out{more}"
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
    repeat: Sequence[Signals] = (),
) -> Session:
    """The session that within its minutes does most for all questions at once, and what it is expected to settle.

    Every kind of question weighs alike. A question that is as good as settled attracts no more minutes. ``shown_ranges`` are those of
    earlier recordings; the motions of those to ``repeat`` come first, as many as fit beside one more piece and one to hold out. Raises InputError for a budget that cannot be used, NotSolvedError where too few motions keep the limits.
    """
    heavy = None if budget.load is None else with_load(model, budget.load)
    cell = cell_of(model, heavy, budget.limits, budget.table, budget.clearance, budget.meshes, budget.seed)
    evidence = Evidence(model, noise, questions)
    pieces = make_pieces(cell, budget.pool, False, budget.seed + 1)
    loaded = None if heavy is None else loaded_pieces(model, heavy, cell, noise, budget.minutes, budget.seed + 2)
    if len(pieces) < 3:
        raise NotSolvedError(
            "fewer than three motions within the limits were found; expected wider limits, another --table, or --limits joint"
        )
    spare = 60 * budget.minutes - (0.0 if loaded is None else loaded.duration)
    repeated, broken = repeated_pieces(cell, repeat, spare - 2 * LENGTH)
    candidates = []
    for k, piece in enumerate(every := [*repeated, *pieces]):
        candidates.append(_Candidate(piece, evidence.shown(piece.motion), ranges_of(model, piece.motion)))
        progress((k + 1) / (len(every) + 2))
    possible = reduce(Ranges.joined, (one.ranges for one in candidates))
    evidence.sized_by(reduce(Shown.__add__, (one.shown for one in candidates)))
    ranges = open_ranges(shown_ranges, possible)
    score = _Score(evidence, ranges, shown_ranges, possible, budget.minutes)
    again, others = candidates[: len(repeated)], candidates[len(repeated) :]
    chosen, holdout = _chosen(again, others, budget, score, spare)
    progress(1.0)
    if repeated:
        what = (
            "1 piece repeats an earlier motion"
            if len(repeated) == 1
            else f"{len(repeated)} pieces repeat earlier motions"
        )
        broken = [f"{what}: {ANY_CHANGE}", *broken]
    session = _session(chosen, holdout, budget, score, noise_words, (*notes, *broken))
    session = session if loaded is None else _with_loaded(session, loaded)
    return _with_spare_time(session, budget.minutes)


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
        return reduce(Shown.__add__, (one.shown for one in chosen), self.evidence.nothing)

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
    again: list[_Candidate], others: list[_Candidate], budget: Budget, score: _Score, spare: float
) -> tuple[list[_Candidate], _Candidate]:
    """The candidates to fit, first those that repeat a motion, and the one to hold out: of the Fourier pieces, the one that moves
    most. All of them last ``spare`` seconds at most, as far as two pieces to fit and one to hold out do."""
    free = [one for one in others if one.piece.kind == "fourier"] or others
    room = np.maximum(score.possible.size, 1e-12)
    holdout = max(free, key=lambda one: float(np.mean(one.ranges.size / room)))
    parts = [*again, *(one for one in others if one is not holdout)]
    seconds = [one.piece.motion.duration for one in parts]
    spare -= holdout.piece.motion.duration
    spare -= 2 * LENGTH if budget.minutes * 60 >= WITH_WARM_UP else 0.0
    picked = choose(parts, seconds, spare, score, range(len(again)))
    # a diagnosis compares recordings: where nothing is open, still the pieces that move most
    more = sorted(
        (i for i in range(len(parts)) if i not in picked and seconds[i] <= LENGTH + SAME),
        key=lambda i: -float(np.mean(parts[i].ranges.size / room)),
    )
    picked += more[: max(0, FEWEST - len(picked))]
    return [parts[i] for i in picked], holdout


def _session(
    chosen: list[_Candidate],
    holdout: _Candidate,
    budget: Budget,
    score: _Score,
    noise_words: str,
    notes: tuple[str, ...],
) -> Session:
    """The legs in the order to record them, and what is expected of them."""
    names = [f"{k:02d}_{one.piece.kind}" for k, one in enumerate(chosen, 1)]
    legs = []
    for name, one in zip(names, chosen, strict=True):
        settles = worse_without(score.evidence, score.shown(chosen), one.shown)
        legs.append(_leg(name, one.piece, piece_purpose(one.piece), settles))
    used = sum(one.piece.motion.duration for one in (*chosen, holdout))
    twice = _to_record_twice(chosen, 60 * budget.minutes - used) if budget.minutes * 60 >= WITH_WARM_UP else None
    last = _leg(
        f"{len(chosen) + 1:02d}_validation", holdout.piece, "validation: nothing is fitted to it", (), holdout=True
    )
    legs.append(last)
    if twice is not None:
        first = chosen[twice]
        warm = _leg("00_warm_up", first.piece, "warms gears and grease; not fitted", (), warm_up=True)
        repeat = _leg(
            f"{len(chosen) + 2:02d}_repeat", first.piece,
            f"repeats {names[twice]}: what differs is the noise floor and the drift", (),
        )  # fmt: skip
        legs = [warm, *legs, repeat]
        chosen = [*chosen, first]
    expected, hidden = expectations_of(
        score.evidence, score.shown(chosen), score.ranges, score.joined(chosen), score.possible
    )
    outlook = Outlook(
        expectations=expected,
        curve=_curve(chosen, score),
        load=budget.load,
        noise=noise_words,
        notes=(*notes, hidden_text(hidden)) if hidden else notes,
    )
    return Session(tuple(legs), (), outlook)


def _to_record_twice(chosen: Sequence[_Candidate], room: float) -> int | None:
    """The piece that also warms the arm and ends the session within so many seconds: of those that fit a Fourier piece, or the shortest."""
    seconds = [one.piece.motion.duration for one in chosen]
    fitting = [k for k in range(len(chosen)) if 2 * seconds[k] <= room + SAME]
    return min(fitting, key=lambda k: (chosen[k].piece.kind != "fourier", seconds[k]), default=None)


def _with_spare_time(session: Session, minutes: float) -> Session:
    """The session with a note where it is done before its time."""
    spare = minutes - session.duration / 60
    if session.outlook is None or spare * 60 < LENGTH:
        return session
    note = f"{spare:.1f} of {minutes:g} minutes are left: more pieces are not expected to settle more"
    return replace(session, outlook=replace(session.outlook, notes=(*session.outlook.notes, note)))


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
        expected, _ = expectations_of(
            score.evidence, score.shown(part), score.ranges, score.joined(part), score.possible
        )
        result.append((minutes, float(sum(e.settled for e in expected))))
    return tuple(result)


def _with_loaded(session: Session, loaded: LoadedPieces) -> Session:
    """The session with its loaded pieces last, so that the load is fixed to the tool once."""
    first = 1 + sum(not leg.warm_up for leg in session.legs)
    legs = [
        _leg(
            f"{first + k:02d}_{one.kind}_loaded", one, "with the load: the drive gains; not pooled with the others", ()
        )
        for k, one in enumerate(loaded.pieces)
    ]
    assert session.outlook is not None
    outlook = replace(session.outlook, notes=(*session.outlook.notes, loaded.note))
    return replace(session, legs=(*session.legs, *legs), outlook=outlook)
