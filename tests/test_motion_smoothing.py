"""The motion of one joint is recovered from noisy positions and velocities, and so is the noise."""

from __future__ import annotations

import numpy as np
import pytest

import physident as pid
from physident.recordings.channels import Channels
from physident.recordings.motion_smoothing import MotionNoise, encoder_step, estimate_noise, smooth_motion
from physident.recordings.recording import recording_from_rows

RATE = 125.0
Array = np.ndarray


def motion(samples: int = 4000, rate: float = RATE) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration of two sines, in closed form."""
    time = np.arange(samples) / rate
    parts = [(0.8, 0.3, 0.4), (0.2, 1.1, 1.3)]  # rad, Hz, rad
    q = sum(A * np.sin(2 * np.pi * f * time + p) for A, f, p in parts)
    v = sum(A * 2 * np.pi * f * np.cos(2 * np.pi * f * time + p) for A, f, p in parts)
    a = sum(-A * (2 * np.pi * f) ** 2 * np.sin(2 * np.pi * f * time + p) for A, f, p in parts)
    return np.asarray(q), np.asarray(v), np.asarray(a)


@pytest.mark.parametrize("rate", [125.0, 500.0])
@pytest.mark.parametrize(("position", "velocity"), [(5e-5, 5e-3), (1e-3, 5e-2), (1e-5, 1e-3)])
def test_noise_is_estimated_and_velocity_is_better_than_measured(position: float, velocity: float, rate: float) -> None:
    rng = np.random.default_rng(1)
    q, v, a = motion(rate=rate)
    noisy = q + position * rng.normal(size=q.shape), v + velocity * rng.normal(size=v.shape)
    noise = estimate_noise(*noisy, rate, 0.0)
    # of a thousand samples; the search ends at steps of a seventh of each standard deviation
    assert noise.position == pytest.approx(position, rel=0.25)
    assert noise.velocity == pytest.approx(velocity, rel=0.25)
    smoothed = smooth_motion(*noisy, rate, noise)
    inner = slice(50, -50)
    error = float(np.std((smoothed.v - v)[inner]))
    assert error < 0.6 * velocity
    assert error < 1.3 * smoothed.v_std  # the motion of two sines is smoother than one whose jerk is white
    assert np.std((smoothed.q - q)[inner]) < position
    assert np.abs(smoothed.a - a)[inner].max() < 0.25 * np.abs(a).max()


@pytest.mark.parametrize("samples", [40, 4000])
def test_without_velocities_they_come_from_positions(samples: int) -> None:
    q, v, _ = motion(samples)
    noisy = q + 1e-4 * np.random.default_rng(2).normal(size=q.shape)
    noise = estimate_noise(noisy, None, RATE, 0.0)
    assert np.isinf(noise.velocity)
    smoothed = smooth_motion(noisy, None, RATE, noise)
    raw = np.gradient(noisy, 1 / RATE)
    assert np.std(smoothed.v[5:-5] - v[5:-5]) < 0.6 * np.std(raw[5:-5] - v[5:-5])


def test_velocity_std_is_that_of_a_motion_of_white_jerk() -> None:
    """Drawn from the smoother's own assumption, the velocity errs by what it states."""
    rng, samples = np.random.default_rng(3), 6000
    noise = MotionNoise(position=1e-4, velocity=2e-3, clock=0.0, jerk=20.0)
    h = 1 / RATE
    step = np.array([[1, h, h**2 / 2], [0, 1, h], [0, 0, 1]])
    spread = noise.jerk * np.array(
        [[h**5 / 20, h**4 / 8, h**3 / 6], [h**4 / 8, h**3 / 3, h**2 / 2], [h**3 / 6, h**2 / 2, h]]
    )
    pushes = rng.multivariate_normal(np.zeros(3), spread, size=samples)
    states = np.zeros((samples, 3))
    for k in range(1, samples):
        states[k] = step @ states[k - 1] + pushes[k]
    q, v = states[:, 0] + 1e-4 * rng.normal(size=samples), states[:, 1] + 2e-3 * rng.normal(size=samples)
    smoothed = smooth_motion(q, v, RATE, noise)
    error = np.std((smoothed.v - states[:, 1])[100:-100])
    assert error == pytest.approx(smoothed.v_std, rel=0.1)  # five times the error of a variance from so many samples


@pytest.mark.parametrize("scale", [1.0, 1e-6, 1e6])
def test_exact_data_stay_as_they_are(scale: float) -> None:
    q, v, _ = (scale * x for x in motion())
    smoothed = smooth_motion(q, v, RATE, estimate_noise(q, v, RATE, 0.0))
    size = max(1.0, scale)
    np.testing.assert_allclose(smoothed.q, q, atol=1e-6 * size)
    np.testing.assert_allclose(smoothed.v, v, atol=1e-4 * size)


@pytest.mark.parametrize("measured", [True, False])
@pytest.mark.parametrize("q", [np.zeros(2000), np.full(2000, 1e6), np.arange(2000.0), np.ones(20), np.arange(4.0)])
def test_a_joint_that_rests_or_moves_evenly(q: Array, measured: bool) -> None:
    v = np.gradient(q, 1 / RATE)
    smoothed = smooth_motion(q, v if measured else None, RATE, estimate_noise(q, v if measured else None, RATE, 0.0))
    np.testing.assert_allclose(smoothed.v, v, atol=1e-5 * max(1.0, np.abs(q).max()))
    assert 0 < smoothed.v_std < 1e-2 * max(1.0, np.abs(q).max())


def test_noise_at_rest_is_no_motion() -> None:
    rng = np.random.default_rng(4)
    noise = estimate_noise(1 + 1e-3 * rng.normal(size=2000), None, RATE, 0.0)
    assert noise.position == pytest.approx(1e-3, rel=0.25)


def test_velocities_that_contradict_positions_are_not_believed() -> None:
    q, v, _ = motion()
    smoothed = smooth_motion(q, 0 * q, RATE, estimate_noise(q, 0 * q, RATE, 0.0))
    np.testing.assert_allclose(smoothed.v, v, atol=1e-2)


def test_position_noise_is_at_least_the_encoders() -> None:
    q, v, _ = motion()
    step = 2e-3
    rounded = step * np.round(q / step)
    assert encoder_step(rounded) == pytest.approx(step)
    noise = estimate_noise(rounded, v, RATE, encoder_step(rounded))
    assert noise.position >= (1 - 1e-9) * step / np.sqrt(12)
    assert noise.position_range == pytest.approx(np.sqrt(12) * noise.position)
    assert encoder_step(np.ones(5)) == 0.0


def recording(samples: Array) -> pid.Recording:
    """One joint, of which some samples are recorded."""
    q, v, a = (x[samples, None] for x in motion())
    return recording_from_rows(
        Channels(time=samples / RATE, q=q, effort=a, effort_kind="torque", dq=v), f"{len(samples)} samples"
    )


def test_a_gap_is_not_smoothed_over() -> None:
    samples = np.r_[0:1500, 2500:4000]
    signals = pid.prepare(recording(samples), pid.Filter())
    assert len(signals.segments) == 2
    _, v, _ = motion()
    np.testing.assert_allclose(signals.v[:, 0], v[np.round(signals.time * RATE).astype(int)], atol=1e-4)


def test_too_few_samples_are_refused() -> None:
    samples = np.arange(4000)
    with pytest.raises(pid.InputError, match="no part without gaps is as long as the filter"):
        pid.prepare(recording(samples[samples % 60 < 20]), pid.Filter())
