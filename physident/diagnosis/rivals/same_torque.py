"""Effects that make the same torque on any motion of an arm within the ranges that were recorded.

What such effects stand for cannot be told apart by these recordings or longer ones, whatever little each of them explains beside
the other: the tilt of a planar arm and the zero of its first joint. They are found
by what their columns can make on a motion that moves every joint through its range at random, and not by what they gained.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate
from physident.diagnosis.problem.problem import DiagnosisProblem
from physident.diagnosis.rivals.refuted import is_refuted
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.statistics.normal_equations import whitening
from physident.diagnosis.statistics.stored_products import Key
from physident.dynamics.regressor import Regressor, build_regressor
from physident.effects.classification import Family
from physident.effects.learned.curve import LearnedCurve
from physident.large_arrays import limits, magnitude
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
DURATION = 40.0  # s: every joint then moves through its range some ten times, in step with no other
PARTS = 4  # sines of each joint's motion
RATE = 20.0  # samples for each period of the cutoff
SLIDING = (1.0, 10.0)  # rad/s|m/s: friction of any width has turned there
NEARLY = 0.05  # share of a power: the torque that is left is less than a quarter of the effect, on each joint or of that joint's noise


def same_torque(hypothesis: Hypothesis) -> dict[Key, list[Candidate]]:
    """For each accepted effect, by name and joints, the candidates with as few numbers that make nearly its torque on any motion.

    What the model's own parameters take up while they are refitted does not count for either.
    """
    accepted = [a for a in hypothesis.accepted if a.candidate is not CONTACT]
    if not accepted:
        return {}
    problem = hypothesis.problem
    signals = random_motion(problem)
    effects = [
        *problem.model.effects,
        *(o.effect for c in problem.candidates for o in c.options if o.effect is not None),
    ]
    # by the model without what was found: a scale of a joint's torque would else hold the finding itself, beside what the model takes up
    regressor = build_regressor(problem.model.robot, effects, [signals], problem.filter, model=problem.model)
    every = stacked(regressor, hypothesis.fit.sigma)
    outside = outside_of(every, problem)
    every = outside(every)
    taken = problem.barred | {a.candidate.key for a in accepted}
    others = [
        (c, [Span.of(every[:, o.columns]) for o in c.options])
        for c in problem.candidates
        if c.key not in taken and not problem.is_friction_of_resting_joint(c) and not _follows_any_motion(c)
    ]
    result, n = {}, problem.model.robot.n
    for i, (one, values) in enumerate(zip(hypothesis.accepted, hypothesis.effect_values, strict=True)):
        if one.candidate is CONTACT:
            continue
        own = build_regressor(problem.model.robot, [one.effect], [signals], problem.filter, model=hypothesis.model)
        columns = outside(stacked(own, hypothesis.fit.sigma))
        most = _rank(columns) + (len(one.candidate.options) > 1)
        torque = columns @ values
        level = _of_this_level(hypothesis, i)
        result[one.candidate.key] = level + [
            c
            for c, spans in others
            if c not in level and any(span.makes(torque, most - (len(spans) > 1), n) for span in spans)
        ]
    return result


def _of_this_level(hypothesis: Hypothesis, i: int) -> list[Candidate]:
    """Of accepted effect i, where it is friction of the model that builds up over a distance, the candidates of its joint with the
    same friction where it slides.

    How much friction a joint has and over which distance it builds up are two things. Where the model has the distance, what changes
    is how much: Coulomb friction of a joint with bristles is this, though the one by the sign of velocity fits it worse at reversals.
    """
    problem, one = hypothesis.problem, hypothesis.accepted[i]
    new = hypothesis.extension.places[i].min() >= len(problem.model.theta)
    if new or one.effect.pointwise or one.effect.family is not Family.FRICTION:
        return []
    robot, speeds = problem.model.robot, np.array(SLIDING)
    steady = one.effect.friction(robot, speeds)
    return [
        c
        for c in problem.candidates
        if c.joints == one.candidate.joints
        and c.key not in problem.barred
        and (effect := c.options[0].effect) is not None
        and c.key != one.candidate.key
        and effect.family is Family.FRICTION
        and _is_multiple(effect.friction(robot, speeds), steady)
    ]


def _is_multiple(one: Array, other: Array) -> bool:
    """Whether the steady friction (1, S) of one effect is a multiple of another one's."""
    if one.shape != other.shape or not (one.any() and other.any()):
        return False
    return bool(np.allclose(one / np.abs(one).max(), other / np.abs(other).max()))


def by_simpler(
    hypothesis: Hypothesis, same: Mapping[Key, Sequence[Candidate]]
) -> tuple[tuple[AcceptedEffect, ...], dict[Key, Key]]:
    """The accepted effects, each that makes nearly the torque of a simpler one of its family on any motion (the ``same`` torque) replaced by
    that one; and which one stands for which.

    At reversals an effect that follows the distance fits better than the same friction by the sign of a velocity that is known with
    noise: presliding over no distance is Coulomb friction. So is friction that grows with a load that is always the same. A curve over
    another quantity is nothing simpler: it was held against this one on left-out rows. What these rows refute stands for nothing.
    """
    taken, result, stands_for = {a.candidate.key for a in hypothesis.accepted}, [], dict[Key, Key]()
    weights = hypothesis.fit.weights**2
    for one in hypothesis.accepted:
        simpler = [
            c
            for c in same.get(one.candidate.key, ())
            if c.joints == one.candidate.joints
            and c.key not in taken
            and _is_simpler(hypothesis.problem, c, one.candidate)
            and (effect := c.options[0].effect) is not None
            and effect.family is one.effect.family
            and (effect.family is not Family.LEARNED or effect.variable == one.effect.variable)
        ]
        if not simpler:
            result.append(one)
            continue
        rest = [a for a in hypothesis.accepted if a is not one]
        beside = state_hypothesis(hypothesis.problem, rest, hypothesis.model, hypothesis.data)
        chosen = min(simpler, key=lambda c: c.size)
        instead = beside.with_effect(chosen, refine_shape(beside, chosen))
        if is_refuted(*(weights * state.left_out_squares for state in (hypothesis, instead))):
            result.append(one)
            continue
        result.append(instead.accepted[-1])
        taken.add(chosen.key)
        stands_for[chosen.key] = one.candidate.key
    return tuple(result), stands_for


def _is_simpler(problem: DiagnosisProblem, candidate: Candidate, than: Candidate) -> bool:
    """Whether a candidate has fewer numbers, or as many and changes what the model has, where the other one would appear anew."""
    changes = candidate.key in problem.present and than.key not in problem.present
    return candidate.size < than.size or (candidate.size == than.size and changes)


def random_motion(problem: DiagnosisProblem) -> Signals:
    """A motion of all joints through the ranges that the recordings show, as fast as in them, and out of step."""
    ends = np.array([limits(one.q) for one in problem.signals])
    low, high = ends[..., 0].min(axis=0), ends[..., 1].max(axis=0)
    middle, half = (high + low) / 2, (high - low) / 2
    speed = np.max([magnitude(one.v) for one in problem.signals], axis=0)
    rng = np.random.default_rng([problem.seed, 47])
    cutoff = problem.filter.cutoff
    fastest = np.minimum(speed / np.maximum(half, 1e-9), np.pi * cutoff)  # rad/s of a sine
    rate = RATE * cutoff
    time = np.arange(round(DURATION * rate)) / rate
    omega = fastest * rng.uniform(0.3, 1.0, (PARTS, len(half)))
    angle = time[:, None, None] * omega + rng.uniform(0, 2 * np.pi, omega.shape)
    parts = np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle)
    position, velocity, acceleration = (part.sum(axis=1) for part in parts)
    scale = half / np.maximum(np.abs(position).max(axis=0), 1e-9)
    return replace(
        problem.signals[0],
        time=time,
        q=middle + scale * position,
        v=scale * velocity,
        a=scale * acceleration,
        torque=np.zeros_like(position),
        temperature=_temperature(problem.signals, time),
        starts=(0,),
        rate=rate,
        origin=0.0,
        recording="",
        rests=None,
    )


def _follows_any_motion(candidate: Candidate) -> bool:
    """Whether a candidate is a curve over time, or over a temperature that rises with it: along one motion it makes any slow torque."""
    effect = candidate.options[0].effect
    return isinstance(effect, LearnedCurve) and effect.variable in ("time", "temperature")


def _temperature(signals: Sequence[Signals], time: Array) -> Array | None:
    """A temperature (N, n) that rises through the recorded range, where every recording has one."""
    given = [one.temperature for one in signals if one.temperature is not None]
    if len(given) < len(signals):
        return None
    low, high = np.min([t.min(axis=0) for t in given], axis=0), np.max([t.max(axis=0) for t in given], axis=0)
    return low + (high - low) * (time / time[-1])[:, None]


def stacked(regressor: Regressor, sigma: Array) -> Array:
    """The dense columns (M n, p), each joint's rows in units of its noise."""
    return (regressor.Y / sigma[:, None]).reshape(-1, len(regressor.columns))


def outside_of(every: Array, problem: DiagnosisProblem) -> Callable[[Array], Array]:
    """What takes from columns the part that lies inside the parameters that are refitted freely."""
    p = len(problem.model.theta)
    free = problem.freedom.map[:, problem.freedom.prior == 0]
    B = every[:, :p] @ free[:, : free.shape[1] - len(problem.freedom.nuisance)]
    size = np.linalg.norm(B, axis=0)
    B = B[:, size > 0] / size[size > 0]
    u, s, _ = np.linalg.svd(B, full_matrices=False)
    Q = u[:, s > 1e-6 * s.max(initial=0.0)]
    return lambda columns: columns - Q @ (Q.T @ columns)


def _rank(columns: Array) -> int:
    """How many independent torques some columns make."""
    size = np.linalg.norm(columns, axis=0)
    kept = columns[:, size > 1e-6 * size.max(initial=0.0)]
    s = np.linalg.svd(kept / np.linalg.norm(kept, axis=0), compute_uv=False)
    return int(np.sum(s > 1e-3 * s.max(initial=0.0)))


@dataclass(frozen=True, eq=False)
class Span:
    """What ``columns`` (M n, k) can make: ``projector`` (k, M n) gives the values that come nearest to a torque."""

    columns: Array
    projector: Array
    rank: int

    @staticmethod
    def of(columns: Array) -> Span:
        if not columns.any():
            return Span(columns, columns.T, 0)
        inner = columns.T @ columns
        root = whitening(inner[None], inner[None])[0]
        return Span(columns, root @ (root.T @ columns.T), _rank(columns))

    def makes(self, torque: Array, most: int, n: int) -> bool:
        """Whether columns of at most so many independent torques make nearly all of a torque of n joints, in units of their noise, and on each
        joint all but what is small beside it or beside noise: a weight on a slide is an offset there, and inertia to the joints before it."""
        if not torque.any() or not 0 < self.rank <= most:
            return False
        left = (torque - self.columns @ (self.projector @ torque)).reshape(-1, n)
        power, rest = (np.sum(part.reshape(-1, n) ** 2, axis=0) for part in (torque, left))
        alike = rest.sum() < NEARLY * power.sum() and (rest < NEARLY * np.maximum(power, len(left))).all()
        return bool(alike)
