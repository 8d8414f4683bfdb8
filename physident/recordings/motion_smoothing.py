"""Position, velocity and acceleration of one joint together, from all that a recording says about its motion.

Position and velocity are two noisy measurements of one motion. Where its jerk is white noise, the motion that fits both
best is the solution of one banded system of equations: a Kalman smoother over the whole recording (Rauch, Tung, Striebel,
"Maximum likelihood estimates of linear dynamic systems" (1965), in its information form). The variances come from the
recording: they are those that make it most likely.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from physident.large_arrays import blocks

Array = NDArray[np.float64]
BAND = 5  # off-diagonals of the normal matrix of three states a sample, each coupled to the next sample's
SHOWN = 600  # samples from which the variances are estimated: their relative error is then five per cent
ROUGH = 9  # samples of a local parabola
FEW = 300  # samples from which the start of the search is chosen
STEP = 2.0  # natural logarithm of the first step of each variance; halved until it is below SETTLED
SETTLED = 0.3
MEMORY = 100  # samples over which positions are averaged at most: a joint at rest has no limit
EXACT = 1e-9  # of the largest value: no position or velocity is known better
PIECE = 1 << 17  # samples solved for at once
OVERLAP = 64 * MEMORY  # samples around a piece: the smoother forgets by e in two memories at most, so 1e-14


@dataclass(frozen=True, kw_only=True)
class MotionNoise:
    """What is uncertain about one joint's motion: standard deviations of its position [rad|m] and velocity [rad/s|m/s],
    infinite where velocity is not measured; that of the ``clock`` [s], which matters the more the faster the joint; and the
    power density of its jerk [(rad/s^3)^2/Hz]."""

    position: float
    velocity: float
    clock: float
    jerk: float

    @property
    def position_range(self) -> float:
        """Range [rad|m] in which the positions of a resting joint stay: that of a uniform error, such as rounding."""
        return np.sqrt(12) * self.position


@dataclass(frozen=True, eq=False)
class SmoothedMotion:
    """The most likely ``q``, ``v``, ``a`` (N,) of one joint, the standard deviation ``v_std`` [rad/s|m/s] of ``v``, and the
    ``noise`` it was found with."""

    q: Array
    v: Array
    a: Array
    v_std: float
    noise: MotionNoise


def smooth_motion(q: Array, dq: Array | None, rate: float, noise: MotionNoise) -> SmoothedMotion:
    """The most likely motion of one joint from positions (N,) and, where measured, velocities (N,) at ``rate`` [Hz]; without
    velocities at least four positions determine it."""
    parts = [smooth_piece(q, dq, rate, noise, piece) for piece in pieces_of(len(q))]
    q, v, a = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    return SmoothedMotion(q=q, v=v, a=a, v_std=velocity_std(rate, noise), noise=noise)


def pieces_of(samples: int) -> list[slice]:
    """The pieces in which ``samples`` of a motion are solved for."""
    return list(blocks(samples, PIECE))


def smooth_piece(
    q: Array, dq: Array | None, rate: float, noise: MotionNoise, piece: slice
) -> tuple[Array, Array, Array]:
    """The most likely position, velocity and acceleration (K,) of a piece of a motion; arguments as for ``smooth_motion``.

    The measurements ``OVERLAP`` samples around the piece count as well: those beyond change nothing.
    """
    around = slice(max(0, piece.start - OVERLAP), min(len(q), piece.stop + OVERLAP))
    q, dq = q[around], None if dq is None else dq[around]
    states, _ = _solve(q, dq, rate, noise.jerk, *_variances(noise, _rough_motion(q, rate)))
    states = states[piece.start - around.start : piece.stop - around.start]
    return states[:, 0], states[:, 1] * rate, states[:, 2] * rate**2


def encoder_step(q: Array) -> float:
    """The smallest difference [rad|m] between two of the positions (N,) that were recorded: the encoder's step, if it has one.

    Positions nearer than ``EXACT`` have no step: which two of them are nearest is then not looked for any further.
    """
    levels, smallest = np.zeros(0), np.inf
    for rows in blocks(len(q)):
        levels = np.unique(np.concatenate([levels, q[rows]]))
        smallest = float(np.diff(levels).min(initial=np.inf))
        if smallest < EXACT:
            break
    return smallest if np.isfinite(smallest) else 0.0


def estimate_noise(q: Array, dq: Array | None, rate: float, encoder_step: float) -> MotionNoise:
    """The noise that makes a recorded motion of one joint most likely; position noise is at least that of rounding to
    ``encoder_step`` [rad|m]."""
    window = _liveliest(q, SHOWN)
    return _estimated(q[window].tobytes(), None if dq is None else dq[window].tobytes(), rate, encoder_step)


@lru_cache(maxsize=512)  # a recording is prepared again for each verb and each filter
def _estimated(q_bytes: bytes, dq_bytes: bytes | None, rate: float, encoder_step: float) -> MotionNoise:
    q, dq = np.frombuffer(q_bytes), None if dq_bytes is None else np.frombuffer(dq_bytes)
    least = MotionNoise(
        position=max(encoder_step / np.sqrt(12), _exactness(q)), velocity=np.inf if dq is None else _exactness(dq),
        clock=1e-6 / rate, jerk=0.0,
    )  # fmt: skip
    moved = _rough_motion(q, rate)
    starts = _starts(q, dq, rate, least, moved)
    few = slice(0, FEW)
    some_q, some_dq = q[few], None if dq is None else dq[few]
    first = min(starts, key=lambda noise: _misfit(some_q, some_dq, rate, noise, moved[:, few]))
    return _most_likely(q, dq, rate, first, least, moved)


def _starts(q: Array, dq: Array | None, rate: float, least: MotionNoise, moved: Array) -> list[MotionNoise]:
    """Where to start from: what the positions change by from sample to sample may be motion, or noise, or a part of each."""
    third = float(np.std(np.diff(q, 3))) if len(q) > ROUGH else 0.0
    white = max(third / np.sqrt(20), least.position)  # third differences of white noise have 20 times its variance
    rough = max(min(third * rate**2.5, 10.0), 1e-6) ** 2
    velocities, fastest = [least.velocity], float(np.abs(moved[0]).max())
    if dq is not None:
        still = float(np.std(np.diff(dq, 3))) / np.sqrt(20) if len(dq) > ROUGH else 0.0
        tried = (least.position * rate / 10, 1e-6, still, float(np.std(dq - moved[0])))
        velocities = [max(least.velocity, speed) for speed in tried]
    found = []
    for position, velocity, jerk in product((least.position, white), velocities, (rough, 1e-4 * rough, 0.0)):
        noise = replace(least, position=position, velocity=velocity, clock=1e-3 / rate)
        found.append(replace(noise, jerk=max(jerk, 10 * _least_jerk(noise, rate, fastest))))
    return list(dict.fromkeys(found))


def _exactness(values: Array) -> float:
    return EXACT * max(1.0, float(np.abs(values).max()))


def _least_jerk(noise: MotionNoise, rate: float, fastest: float) -> float:
    """The power density of jerk with which positions are averaged over ``MEMORY`` samples, at the ``fastest`` speed."""
    return (noise.position**2 + (noise.clock * fastest) ** 2) * rate**5 / MEMORY**6


def _most_likely(
    q: Array, dq: Array | None, rate: float, noise: MotionNoise, least: MotionNoise, moved: Array
) -> MotionNoise:
    """Coordinate descent over the logarithms of the variances, none below those of ``least``."""
    names = ["jerk", "clock", "position"] + (["velocity"] if dq is not None else [])
    fastest = float(np.abs(moved[0]).max())
    best, size = _misfit(q, dq, rate, noise, moved), STEP
    while size > SETTLED:
        untried = list(names)
        while untried:
            name = untried.pop(0)
            for sign in (1, -1):
                start, factor = noise, float(np.exp(sign * size / (1 if name == "jerk" else 2)))
                while True:
                    trial = replace(noise, **{name: getattr(noise, name) * factor})
                    if getattr(trial, name) < getattr(least, name) or trial.jerk < _least_jerk(trial, rate, fastest):
                        break
                    if not (misfit := _misfit(q, dq, rate, trial, moved)) < best - 1e-6:
                        break
                    noise, best = trial, misfit
                if noise is not start:  # the way back leads to what was worse; the others may now do better
                    untried = names[names.index(name) + 1 :] + names[: names.index(name)]
                    break
        size /= 2
    return noise


def _rough_motion(q: Array, rate: float) -> Array:
    """Velocity and acceleration (2, N) of positions (N,), good enough for what an uncertain clock makes of them: those of the
    parabola through the ``ROUGH`` samples around each, or through the first or last of them."""
    count = len(q)
    width = min(ROUGH, (count - 1) // 2 * 2 + 1)
    if width < 3:
        return np.zeros((2, count))
    half = width // 2
    parabolas = np.lib.stride_tricks.sliding_window_view(q, width) @ _slope_and_curvature(width)
    sample = np.arange(count)
    middle = np.clip(sample, half, count - 1 - half)
    slope, curvature = parabolas[middle - half].T
    return np.array([(slope + 2 * curvature * (sample - middle)) * rate, 2 * curvature * rate**2])


@lru_cache
def _slope_and_curvature(width: int) -> Array:
    """What the samples (width,) are multiplied by for the linear and the quadratic coefficient (width, 2) of their parabola."""
    t = np.arange(width) - width // 2
    return np.linalg.pinv(np.vander(t, 3, increasing=True))[1:].T


def _variances(noise: MotionNoise, moved: Array) -> tuple[Array, Array]:
    """Variance (N,) of each position and velocity."""
    v, a = moved
    return noise.position**2 + (noise.clock * v) ** 2, noise.velocity**2 + (noise.clock * a) ** 2


def _misfit(q: Array, dq: Array | None, rate: float, noise: MotionNoise, moved: Array) -> float:
    """Minus twice the logarithm of the likelihood, but for a constant."""
    position, velocity = _variances(noise, moved)
    states, determinant = _solve(q, dq, rate, noise.jerk, position, velocity)
    jerk = noise.jerk / rate**5
    innovation = (states[1:] - states[:-1] @ _TRANSITION.T) @ _ROOT
    total = float(np.vdot(innovation, innovation)) / jerk + determinant + 3 * (len(q) - 1) * np.log(jerk)
    total += float(((q - states[:, 0]) ** 2 / position + np.log(position)).sum())
    if dq is not None:
        total += float(((dq - states[:, 1] * rate) ** 2 / velocity + np.log(velocity)).sum())
    return float(total)


# one step of a motion in units of the sampling interval, and the inverse covariance of what white jerk adds to it
_TRANSITION = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
_INVERSE = np.linalg.inv(np.array([[1 / 20, 1 / 8, 1 / 6], [1 / 8, 1 / 3, 1 / 2], [1 / 6, 1 / 2, 1.0]]))
_ROOT = np.linalg.cholesky(_INVERSE)


def _solve(
    q: Array, dq: Array | None, rate: float, jerk: float, position: Array, velocity: Array
) -> tuple[Array, float]:
    """The states (N, 3) in units of the sampling interval, and the logarithm of the normal matrix's determinant, from the
    variances (N,) of what was measured."""
    from scipy.linalg.lapack import dpbtrs  # pyright: ignore[reportAttributeAccessIssue]

    factor = _factor(position, None if dq is None else velocity, rate, jerk)
    right = np.zeros((len(q), 3))
    right[:, 0] = q / position
    if dq is not None:
        right[:, 1] = dq * rate / velocity
    states, _ = dpbtrs(factor, right.ravel(), overwrite_b=True)
    return states.reshape(len(q), 3), 2 * float(np.log(factor[-1]).sum())


def _factor(position: Array, velocity: Array | None, rate: float, jerk: float) -> Array:
    """The Cholesky factor of the normal matrix, in bands (BAND + 1, 3 N), from the variances (N,) of what was measured."""
    from scipy.linalg.lapack import dpbtrf  # pyright: ignore[reportAttributeAccessIssue]

    N = len(position)
    bands = (_few_bands(N) if N <= SHOWN else _motion_bands(N)) * (rate**5 / jerk)
    bands[BAND, 0::3] += 1 / position
    if velocity is not None:
        bands[BAND, 1::3] += rate**2 / velocity
    factor, failed = dpbtrf(bands, overwrite_ab=True)
    if failed:
        raise np.linalg.LinAlgError("the motion's normal matrix is not positive definite")
    return factor


def _motion_bands(N: int) -> Array:
    """What white jerk of unit power contributes to the normal matrix of N samples, in bands."""
    before, after, couple = _TRANSITION.T @ _INVERSE @ _TRANSITION, _INVERSE, -_TRANSITION.T @ _INVERSE
    bands = np.zeros((BAND + 1, N, 3))
    for row in range(3):
        for column in range(3):
            if row <= column:
                band = bands[BAND + row - column, :, column]
                band[:-1] += before[row, column]
                band[1:] += after[row, column]
            bands[BAND + row - 3 - column, 1:, column] = couple[row, column]
    return np.asfortranarray(bands.reshape(BAND + 1, 3 * N))


_few_bands = lru_cache(maxsize=4)(_motion_bands)  # the noise is searched for with a hundred factors of one length


def velocity_std(rate: float, noise: MotionNoise) -> float:
    """Standard deviation [rad/s|m/s] of the smoothed velocity far from both ends of a recording of a slow motion."""
    from scipy.linalg.lapack import dpbtrs  # pyright: ignore[reportAttributeAccessIssue]

    N = 6 * MEMORY + 1
    variances = _variances(noise, np.zeros((2, N)))
    factor = _factor(variances[0], None if np.isinf(noise.velocity) else variances[1], rate, noise.jerk)
    middle = np.zeros(3 * N)
    middle[3 * (N // 2) + 1] = 1.0
    solved, _ = dpbtrs(factor, middle)
    return float(np.sqrt(middle @ solved)) * rate


def _liveliest(q: Array, length: int) -> slice:
    """The samples (at most ``length``) in which the position changes most."""
    if len(q) <= length:
        return slice(0, len(q))
    start, most, before = 0, -1.0, np.zeros(1)
    for rows in blocks(len(q) - 1):
        # the sums are those over the whole motion: a piece goes on where the one before ended
        steps = np.abs(np.diff(q[rows.start : rows.stop + 1]))
        travelled = np.concatenate([before, np.cumsum(np.concatenate([before[-1:], steps]))[1:]])
        change = travelled[length - 1 :] - travelled[: max(0, len(travelled) - length + 1)]
        if len(change) and change.max() > most:
            most = float(change.max())
            start = rows.stop + 1 - len(travelled) + int(np.argmax(change))
        before = travelled[max(0, len(travelled) - length + 1) :]
    return slice(start, start + length)
