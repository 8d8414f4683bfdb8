"""Inspection finds what was put into a recording; visibility equals an independent projection."""

from __future__ import annotations

import numpy as np

import physident as pid
from physident.recordings.channels import Channels
from physident.recordings.recording import recording_from_rows
from tests.test_identify import _recording


def test_facts_of_a_made_recording() -> None:
    rng = np.random.default_rng(0)
    time = np.cumsum(np.concatenate([[0.0], rng.normal(0.008, 0.0004, size=4999)]))
    delay = 0.012
    moving = (time > 5) & (time < 35)
    phase = 2 * np.pi * 0.4 * (time - 5)
    q = np.where(moving, 1 - np.cos(phase), 0.0)[:, None] * [1.0, 0.5]
    dq = np.where(moving, 2 * np.pi * 0.4 * np.sin(phase - 2 * np.pi * 0.4 * delay), 0.0)[:, None] * [1.0, 0.5]
    effort = q + 0.01 * rng.normal(size=q.shape)
    seen = pid.inspect_recording(
        recording_from_rows(Channels(time=time, q=q, effort=effort, effort_kind="current", dq=dq), "made")
    )
    assert abs(seen.rate - 125) < 2
    assert abs(seen.jitter - 0.0004) < 5e-5
    np.testing.assert_allclose(seen.velocity_delay, delay, atol=1.5e-3)
    assert (seen.velocity_error < 8).all()
    assert abs(seen.rest[0][1] - 5) < 0.1
    assert abs(seen.rest[-1][0] - 35) < 0.1
    np.testing.assert_allclose(seen.motion_band, 0.4, atol=0.15)
    assert 2 <= seen.cutoff <= 10
    assert "suggested --cutoff" in repr(seen)


def test_the_noise_of_a_motion_is_that_of_its_instruments_whatever_its_clock_does() -> None:
    """Each sample is taken when its clock says so, at steps that are a tenth uneven: that is no noise of the motion."""
    rng, position, velocity = np.random.default_rng(4), 3e-5, 2e-3
    for uneven in (0.0, 0.1):
        step = 0.004 * (1 + uneven * rng.uniform(-1, 1, size=5000))
        time = np.cumsum(step)
        angle = time[:, None] * [3.1, 7.3] + [0.2, 1.1]
        q = np.sin(angle) + position * rng.normal(size=angle.shape)
        dq = np.cos(angle) * [3.1, 7.3] + velocity * rng.normal(size=angle.shape)
        effort = q + 0.01 * rng.normal(size=q.shape)
        seen = pid.inspect_recording(pid.Recording.from_arrays(time, q, dq=dq, effort=effort, source="made"))
        # samples between two others have less noise than either
        for found, true in zip(seen.noise[:, :2].T, (position, velocity), strict=True):
            assert (found > 0.5 * true).all(), uneven
            assert (found < 1.5 * true).all(), uneven


def test_visibility_equals_a_projection(ur5: pid.Robot) -> None:
    effects = pid.make_effects(["rigid_body", "rotor_inertia", "coulomb_friction"])
    filter = pid.Filter()
    regressor = pid.build_regressor(ur5, effects, [pid.prepare(_recording(ur5, 1), filter)], filter)
    seen = pid.measure_visibility(regressor)
    names = [c.name for c in seen.columns]
    for name in ("coulomb_friction_1", "rotor_inertia_6", "mcx_6"):
        i = names.index(name)
        scale = np.sqrt((regressor.torque**2).mean(axis=0))
        Y = (regressor.Y / scale[:, None]).reshape(-1, len(names))
        rest = np.delete(Y, i, axis=1)
        size = np.linalg.norm(rest, axis=0)
        rest = rest[:, size > 1e-9] / size[size > 1e-9]
        U, s, _ = np.linalg.svd(rest, full_matrices=False)
        U = U[:, s > 1e-10 * s[0]]
        outside = Y[:, i] - U @ (U.T @ Y[:, i])
        share = (outside @ outside) / (Y[:, i] @ Y[:, i])
        assert abs(seen.share[i] - share) < 1e-6 * max(share, 1e-3)
    # on an upright UR5 the rotor inertias of joints 1 and 2 lie inside the rigid body's columns
    for name in ("rotor_inertia_1", "rotor_inertia_2"):
        assert seen.share[names.index(name)] == 0.0
    assert np.isnan(seen.share[names.index("m_1")])  # joint 1 turns about the vertical: the link's mass does nothing
