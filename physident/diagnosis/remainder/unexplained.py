"""The residual that stays unexplained: its size, its memory, and what it varies with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import PurePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.folds import MEMORIES
from physident.diagnosis.remainder.burst import Burst, bursts_in_words, bursts_of
from physident.diagnosis.remainder.friction_between import FrictionBetween, friction_between
from physident.diagnosis.remainder.predictable import predictable_share
from physident.diagnosis.remainder.shares import share_of_curve, share_of_slowest, slowest_in_words
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.estimation.dry_friction.row_weights import dry_level
from physident.estimation.estimate import Estimate
from physident.estimation.uncertainty import correlation_rows
from physident.estimation.weighting import FINEST
from physident.large_arrays import steps
from physident.recordings.signals import MOVING_SPEED

Array = NDArray[np.float64]
SLOW = 0.2  # Hz
AT_FLOOR = 1.1  # times the noise floor: a tenth more torque error lies within the floor's own scatter
REPEATS = (
    3.0  # times what differs where a motion repeats, or the torque's noise: eight ninths of its power are no such noise
)
GROWN = 3.0  # times: only a large difference is told, for a model errs more along any motion that it never saw
LARGER = 2.0  # times, where nothing says what is usual: structure however short it remembers
NEARLY_ALL = 0.9  # of its power: that at most so much is a function of the state says nothing
AS_OWN = 1.5  # times, at most, where nothing says what is usual: half as much again is what a model errs more by where it has not been
EXACT = 1e-3  # of a joint's torque: torque sensors and motor currents err by more, so a model that errs by less fits exact recordings
STRUCTURED = 2.0  # times the filter's own memory: sums of autocorrelations of white noise scatter by half of it


@dataclass(frozen=True, kw_only=True)
class Unexplained:
    """The residual of one joint: ``rms`` [N m|N], ``lag_one`` correlation, ``memory`` [s] beside the filter's own for white
    noise, ``slow`` share of power below 0.2 Hz, ``peak`` [Hz], and the share of its power that a curve over velocity,
    position, load and time each explains beyond chance; ``order`` of the strongest line over the angle and its share; ``predictable``: the share of its
    power that any function of the joint's position, velocity, acceleration and load can be at most, None where no state was visited
    twice; ``friction_between``: what of it is friction that differs between recordings; ``bursts``: the times that hold much of it; ``times_own``: how many times what the model leaves
    of its own recordings, None where that is not asked, and ``usual_times``: how many it is at most where nothing has changed, None where too few
    recordings tell. ``times_noise``: how many times what the filter passes of the torque signal's own noise, rows that a rest leaves open counted less.
    ``slowest``: the share of its power in the fifth of the rows in which the joint moves slowest. ``unproven``: how many times what the model leaves of
    its own recordings it errs by with the values from before, where nothing that was found acts; None where that is not asked."""

    joint: int
    rms: float
    lag_one: float
    memory: float
    white_memory: float
    slow: float
    peak: float
    velocity: float
    position: float
    load: float
    time: float
    order: float
    order_share: float
    predictable: float | None = None
    friction_between: FrictionBetween | None = None
    bursts: tuple[Burst, ...] = ()
    times_own: float | None = None
    usual_times: float | None = None
    times_noise: float | None = None
    slowest: float = 0.0
    unproven: float | None = None

    @property
    def grown(self) -> bool:
        """Whether it has structure, and is several times as large as on the model's own recordings: of the arm, or of a motion that is far from theirs."""
        return self.structured and self.errs_times > GROWN

    @property
    def is_unproven(self) -> bool:
        """Whether the model errs by far more than on its own recordings until values are fitted to these that are no proven change."""
        return (self.unproven or 0.0) > max(self.usual_times or LARGER, GROWN)

    @property
    def errs_times(self) -> float:
        """How many times what the model leaves of its own recordings it errs by: where that is no proven change, before anything is fitted."""
        return (self.unproven if self.is_unproven else self.times_own) or 0.0

    @property
    def remembers(self) -> bool:
        """Whether it remembers longer than noise through the filter does."""
        return self.memory > STRUCTURED * self.white_memory

    @property
    def as_own(self) -> bool:
        """Whether it remembers longer, and is no larger than on the model's own recordings."""
        return self.remembers and self.times_own is not None and self.times_own <= (self.usual_times or AS_OWN)

    @property
    def may_hide_a_change(self) -> bool:
        """Whether it is larger than on the model's own recordings, and no larger than usual, where these differ by so much that this says little."""
        return self.as_own and (self.times_own or 0.0) > 1.0 and (self.usual_times or 0.0) > LARGER

    @property
    def structured(self) -> bool:
        """Whether it is more than noise, and more than the model leaves on its own recordings, where that is known."""
        return (self.remembers and not self.as_own) or self.errs_times > (self.usual_times or LARGER)

    @property
    def is_loud(self) -> bool:
        """Whether it is by far more than the torque signal's own noise, where nothing says what is usual."""
        return self.times_own is None and self.is_far_above_noise

    @property
    def is_far_above_noise(self) -> bool:
        """Whether it is by far more than the torque signal's own noise, usual or not."""
        return (self.times_noise or 0.0) > REPEATS

    @property
    def description(self) -> str:
        """The largest of what it shows against, in words."""
        shares = {
            "velocity": self.velocity, "position": self.position, "load": self.load, "time": self.time,
            f"order {self.order:g}": self.order_share,
        }  # fmt: skip
        name = max(shares, key=lambda key: shares[key])
        dependence = (
            f"a curve over {name} explains {100 * shares[name]:.0f} % of it"
            if shares[name] > 0.05
            else "no dependence on velocity, position, load or time"
        )
        kind = "" if self.remembers else "it remembers no longer than noise; "
        if self.is_loud and not self.remembers:
            kind = f"it remembers no longer than noise, but is {self.times_noise:.1f} times that of the torque signal; "
        most = max(self.predictable or 0.0, shares[name])
        bound = (
            f"; at most {100 * most:.0f} % of it is any function of the joint's position, velocity, acceleration and load"
            if self.predictable is not None and most < NEARLY_ALL
            else ""
        )
        moment = "".join(f"; {text}" for text in (slowest_in_words(self.slowest), bursts_in_words(self.bursts)) if text)
        moment += f"; {self.friction_between.in_words}" if self.friction_between else ""
        if self.is_unproven:
            moment += (
                f"; with the values from before it errs {self.unproven:.1f} times as much as on its own recordings, and what takes that up here is"
                " no proven change"
            )
        return f"{100 * self.slow:.0f} % of its power is below {SLOW:g} Hz; {kind}{dependence}{moment}{bound}"

    def as_dict(self) -> dict[str, Any]:
        """Its numbers as JSON can hold them."""
        return {**asdict(self), "structured": self.structured, "may_hide_a_change": self.may_hide_a_change}


def above_noise_floor(unexplained: Sequence[Unexplained], noise_floor: Array | None) -> tuple[Unexplained, ...]:
    """The joints whose residual is structured and larger than what differs where a motion repeats, or than the model's own recordings show
    by far: what comes and goes by itself is no function of the motion, and new nevertheless. Where there are none to say what is usual, it is
    also structure, however short it remembers, if nearly all of it repeats with the motion, or where no motion repeats, is more than the torque
    signal's own noise.

    This is the one rule that the verdict, the text, the report and the session follow.
    """
    floor = np.zeros(len(unexplained)) if noise_floor is None else AT_FLOOR * noise_floor

    def is_more(one: Unexplained) -> bool:
        repeats = noise_floor is not None and one.times_own is None and one.rms > REPEATS * noise_floor[one.joint - 1]
        return (
            repeats
            or (noise_floor is None and one.is_loud)
            or (one.structured and (one.rms > floor[one.joint - 1] or one.grown))
        )

    return tuple(filter(is_more, unexplained))


def large_as_usual(unexplained: Sequence[Unexplained], noise_floor: Array | None) -> tuple[Unexplained, ...]:
    """The joints whose residual is no larger than usual, but only because the model errs by several times as much elsewhere, too: it may hold
    more than noise, and no recording tells."""
    floor = np.zeros(len(unexplained)) if noise_floor is None else AT_FLOOR * noise_floor
    return tuple(
        one for one in unexplained if one.as_own and (one.times_own or 0.0) > LARGER and one.rms > floor[one.joint - 1]
    )


def describe_unexplained(hypothesis: Hypothesis) -> tuple[Unexplained, ...]:
    """The residual of each joint of a fitted state."""
    regressor, residual = hypothesis.data.regressor, hypothesis.residual
    rate = regressor.kept_rate
    white = white_memory(hypothesis)
    memory = correlation_rows(regressor, residual)
    q, v, a, load = (_at_rows(hypothesis, name) for name in ("q", "v", "a", "load"))
    signals = hypothesis.problem.signals
    since = regressor.time - np.array([one.origin for one in signals])[regressor.recording]
    names = [PurePath(one.source).name for one in signals]
    # a joint that stands is held by its friction, and by no more than that
    holds = np.abs(residual) <= dry_level(hypothesis.extension.model)
    creeping = holds & (np.abs(v) < MOVING_SPEED * hypothesis.problem.model.robot.radian)
    between, times_noise = friction_between(hypothesis), _times_noise(hypothesis)
    result = []
    for j, r in enumerate(residual.T):
        power, frequency = _spectrum(r, regressor.segment, rate)
        total = max(float(power.sum()), 1e-300)
        worth = len(r) / memory[j]
        orders = np.arange(1, 41)
        waves = np.sum([np.exp(-1j * orders[:, None] * q[some, j]) @ r[some] for some in steps(len(r))], axis=0)
        lines = np.abs(waves) ** 2 * 2 / len(r) / max(float(r @ r), 1e-300)
        top = int(np.argmax(lines))
        clock = regressor.time - regressor.time[0]
        by_v, by_q, by_load, by_time = (share_of_curve(r, x, worth) for x in (v[:, j], q[:, j], load[:, j], clock))
        states = np.column_stack([q[:, j], v[:, j], a[:, j], load[:, j]])
        apart = MEMORIES * float(memory[j]) / rate
        result.append(
            Unexplained(
                joint=j + 1,
                rms=float(np.sqrt(np.mean(r**2))),
                lag_one=_lag_one(r, regressor.segment),
                memory=float(memory[j] / rate),
                white_memory=white / rate,
                slow=float(power[frequency < SLOW].sum() / total),
                peak=float(frequency[np.argmax(power)]),
                velocity=by_v,
                position=by_q,
                load=by_load,
                time=by_time,
                order=float(orders[top]),
                order_share=float(max(0.0, lines[top] - 2 * np.log(40) / worth)),
                predictable=predictable_share(r, states, regressor.time, regressor.recording, apart),
                friction_between=between[j],
                bursts=bursts_of(r, since, regressor.recording, names, worth, creeping[:, j]),
                times_noise=float(times_noise[j]),
                slowest=share_of_slowest(r, v[:, j]),
            )
        )
    return tuple(result)


def _times_noise(hypothesis: Hypothesis) -> Array:
    """How many times (n,) what the torque's own noise makes the residual is; beside exact recordings, what a sensor would tell."""
    problem = hypothesis.problem
    weights = problem.weights**2
    rms = np.sqrt(np.sum(hypothesis.fit.residual**2, axis=0) / np.maximum(weights.sum(axis=0), 1e-300))
    exact = EXACT * np.sqrt(np.mean(hypothesis.torque**2, axis=0))
    return rms / np.maximum(np.maximum(problem.torque_noise, exact), 1e-300)


def incomplete_joints(estimate: Estimate, remainder: Sequence[Unexplained]) -> tuple[int, ...]:
    """Joints (from 1) on which an estimate's residual on its own recordings remembers longer than noise does.

    A residual below the resolution of any torque is none.
    """
    used = sum(source.used for source in estimate.sources)
    memory = used / np.maximum(estimate.effective_samples, 1e-300)
    return tuple(
        r.joint
        for r, joint_memory, left in zip(remainder, memory, estimate.relative, strict=True)
        if joint_memory > STRUCTURED * r.white_memory and left > 100 * FINEST
    )


def white_memory(hypothesis: Hypothesis) -> float:
    """Integrated autocorrelation, in kept rows, of white noise through the filter."""
    filter, rate = hypothesis.problem.filter, hypothesis.problem.signals[0].rate
    taps, D = filter.taps(rate), filter.decimation(rate)
    full = np.correlate(taps, taps, "full")[len(taps) - 1 :: D]
    return max(1.0, float(2 * full.sum() / full[0] - 1))


def _at_rows(hypothesis: Hypothesis, name: str) -> Array:
    """q, v or load (M, n) at the times of the rows."""
    regressor = hypothesis.data.regressor
    rows = []
    for index, signals in enumerate(hypothesis.problem.signals):
        values = hypothesis.model.refer(signals).load if name == "load" else getattr(signals, name)
        assert values is not None
        time = regressor.time[regressor.recording == index]
        at = np.clip(np.searchsorted(signals.time, time), 0, len(signals.time) - 1)
        rows.append(values[at])
    return np.concatenate(rows)


def _spectrum(r: Array, segment: NDArray[np.intp], rate: float) -> tuple[Array, Array]:
    """Power and frequency [Hz] of a series, from its longest contiguous part."""
    longest = np.bincount(segment).argmax()
    part = r[segment == longest]
    power = np.abs(np.fft.rfft((part - part.mean()) * np.hanning(len(part)))) ** 2
    return power, np.asarray(np.fft.rfftfreq(len(part), 1 / rate), dtype=float)


def _lag_one(r: Array, segment: NDArray[np.intp]) -> float:
    together = segment[1:] == segment[:-1]
    return float(np.sum(r[1:][together] * r[:-1][together]) / max(float(r @ r), 1e-300))
