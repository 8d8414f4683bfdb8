"""Motions made of waves: Fourier series, Lissajous figures and a chirp that moves all joints alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from studies.open_world_second.laws import LAWS, window
from tests.truth import ArmTruth

Array = NDArray[np.float64]
DWELL = 0.4  # s of rest at both ends
GRID = 0.005  # s between the instants at which a motion is held against the limits


@dataclass(frozen=True, eq=False)
class Fourier:
    """q = centre + sum_k (sine_k sin + cosine_k cos)(2 pi harmonic_k u) + a polynomial in u that brings both ends to rest.

    ``harmonic`` (K,) are whole; ``sine``, ``cosine`` (K, n) [rad]; u runs from 0 to 1 between the dwells.
    """

    kind: str
    duration: float
    centre: Array
    harmonic: Array
    sine: Array
    cosine: Array

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n) at times (N,) [s]."""
        lasts = self.duration - 2 * DWELL
        u = np.clip((time - DWELL) / lasts, 0, 1)
        rate = 2 * np.pi * self.harmonic
        s, c = np.sin(np.outer(u, rate)), np.cos(np.outer(u, rate))
        bend = self._bend(rate)
        q = self.centre + s @ self.sine + c @ self.cosine + _powers(u, 0) @ bend
        v = (c * rate) @ self.sine - (s * rate) @ self.cosine + _powers(u, 1) @ bend
        a = -((s * rate**2) @ self.sine + (c * rate**2) @ self.cosine) + _powers(u, 2) @ bend
        moving = ((time > DWELL) & (time < self.duration - DWELL))[:, None]
        return q, np.where(moving, v / lasts, 0.0), np.where(moving, a / lasts**2, 0.0)

    def _bend(self, rate: Array) -> Array:
        """Coefficients (6, n): no change of place at the ends, and the series' speed and acceleration there undone."""
        ends = np.array([0.0, 1.0])
        conditions = np.vstack([_powers(ends, order) for order in range(3)])
        speed, acceleration = rate @ self.sine, -(rate**2) @ self.cosine
        zero = np.zeros_like(speed)
        wanted = np.array([zero, zero, -speed, -speed, -acceleration, -acceleration])
        return np.asarray(np.linalg.solve(conditions, wanted), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Lissajous:
    """q = centre + amplitude sin(ratio phi + phase), where one angle phi goes ``turns`` times round by a law with rest."""

    kind: str
    duration: float
    centre: Array
    amplitude: Array
    ratio: Array
    phase: Array
    turns: int
    law: str

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n) at times (N,) [s]."""
        lasts = self.duration - 2 * DWELL
        s0, s1, s2 = (part[:, None] for part in LAWS[self.law]((time - DWELL) / lasts))
        way = 2 * np.pi * self.turns * self.ratio
        angle, rate, push = way * s0 + self.phase, way * s1 / lasts, way * s2 / lasts**2
        sine, cosine = self.amplitude * np.sin(angle), self.amplitude * np.cos(angle)
        return self.centre + sine, cosine * rate, cosine * push - sine * rate**2


@dataclass(frozen=True, eq=False)
class Chirp:
    """All joints swing in step while the frequency rises from ``low`` to ``high`` [Hz]; ``amplitude`` (n,) has signs."""

    kind: str
    duration: float
    centre: Array
    amplitude: Array
    low: float
    high: float

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n) at times (N,) [s]."""
        lasts = self.duration - 2 * DWELL
        t = np.clip(time - DWELL, 0, lasts)
        rise = (self.high - self.low) / lasts
        angle = 2 * np.pi * (self.low * t + rise * t**2 / 2)[:, None]
        rate, push = 2 * np.pi * (self.low + rise * t)[:, None], 2 * np.pi * rise
        s0, s1 = np.sin(angle), rate * np.cos(angle)
        s2 = push * np.cos(angle) - rate**2 * s0
        w0, w1, w2 = window(t, lasts, 0.15 * lasts)
        wave, speed, acceleration = w0 * s0, w1 * s0 + w0 * s1, w2 * s0 + 2 * w1 * s1 + w0 * s2
        return self.centre + wave * self.amplitude, speed * self.amplitude, acceleration * self.amplitude


def fourier(arm: ArmTruth, seed: int, duration: float) -> Fourier:
    """A series of five drawn harmonics for all joints, faster ones with smaller amplitudes."""
    rng = np.random.default_rng([seed, 421])
    fastest = max(6, int(rng.uniform(0.3, 0.8) * (duration - 2 * DWELL)))
    harmonic = np.sort(rng.permutation(fastest)[:5]).astype(np.float64) + 1.0
    fall = harmonic[:, None] ** -rng.uniform(0.5, 1.2)
    sine, cosine = rng.normal(size=(2, 5, arm.joints)) * fall
    trial = Fourier("fourier", duration, np.zeros(arm.joints), harmonic, sine, cosine)
    scale, centre = _fitted(trial.states(_instants(duration)), arm, rng)
    return Fourier("fourier", duration, centre, harmonic, scale * sine, scale * cosine)


def lissajous(arm: ArmTruth, seed: int, duration: float) -> Lissajous:
    """A figure whose joints go round in ratios of small whole numbers."""
    rng = np.random.default_rng([seed, 422])
    ratio = rng.integers(1, 6, arm.joints) / 2.0
    phase, one = rng.uniform(0, 2 * np.pi, arm.joints), np.ones(arm.joints)
    turns = max(2, round(duration * rng.uniform(0.08, 0.2)))
    law = str(rng.choice(["brisk", "cycloid"]))
    trial = Lissajous("lissajous", duration, 0 * one, one, ratio, phase, turns, law)
    scale, centre = _fitted(trial.states(_instants(duration)), arm, rng)
    return Lissajous("lissajous", duration, centre, scale, ratio, phase, turns, law)


def chirp(arm: ArmTruth, seed: int, duration: float) -> Chirp:
    """A sweep that tells joints apart badly."""
    rng = np.random.default_rng([seed, 423])
    low, high = rng.uniform(0.05, 0.15), rng.uniform(0.4, 1.2)
    signs = rng.choice([-1.0, 1.0], arm.joints)
    trial = Chirp("chirp", duration, np.zeros(arm.joints), signs, low, high)
    scale, centre = _fitted(trial.states(_instants(duration)), arm, rng)
    return Chirp("chirp", duration, centre, scale * signs, low, high)


def _instants(duration: float) -> Array:
    return np.linspace(0, duration, int(duration / GRID) + 1)


def _fitted(shape: tuple[Array, Array, Array], arm: ArmTruth, rng: np.random.Generator) -> tuple[Array, Array]:
    """Factor and centre (n,) that bring a shape about zero inside the limits, each joint at its drawn share of top speed."""
    q, v, a = shape
    room = arm.upper - arm.lower
    pace = rng.uniform(0.45, 0.98, arm.joints)
    peak_speed, peak_push = np.abs(v).max(axis=0), np.abs(a).max(axis=0)
    scale = np.minimum.reduce(
        [pace * arm.top_speed / peak_speed, 0.98 * arm.top_acceleration / peak_push, 0.94 * room / np.ptp(q, axis=0)]
    )
    low, high = scale * q.min(axis=0), scale * q.max(axis=0)
    centre = arm.lower - low + rng.uniform(0.03, 0.97, arm.joints) * (room - (high - low))
    return scale, centre


def _powers(u: Array, order: int) -> Array:
    """Derivative of the given order of 1, u, ..., u^5, as (N, 6)."""
    columns = []
    for power in range(6):
        factor = float(np.prod([power - k for k in range(order)]))
        columns.append(factor * u ** max(power - order, 0))
    return np.stack(columns, axis=1)
