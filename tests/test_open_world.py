"""What the open world draws: arms that can be, motions within limits, backgrounds of the stated size.

Whole trials are in test_open_world_trials.py; how often the diagnosis is right is the question of the long run.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from studies.open_world import background, motions, outside, scale
from studies.open_world.arms import arm
from studies.open_world.causes import KINDS, Ground, draw, scaled
from studies.open_world.scoring import split
from studies.open_world.sensors import Sensors
from studies.open_world.sizing import Oracle, strength
from studies.open_world.summary import share
from studies.open_world.world import FirstWorld
from tests.truth import ArmTruth, Run

SEEDS = range(40, 48)
DURATION = 20.0


@pytest.fixture(scope="module", params=SEEDS)
def one(request: pytest.FixtureRequest) -> ArmTruth:
    return arm(request.param)


def test_links_are_bodies_and_differ_from_the_description(one: ArmTruth) -> None:
    nominal = np.array([body.toDynamicParameters() for body in list(scale.bodies(one.urdf).inertias)[1:]])
    assert one.links.shape == nominal.shape
    assert np.abs(one.links[:, 0] / nominal[:, 0] - 1).max() > 0.01
    for link in one.links:
        body = pin.PseudoInertia.FromDynamicParameters(link).toMatrix()
        assert np.linalg.eigvalsh(body).min() > 0


def test_friction_is_of_the_stated_share(one: ArmTruth) -> None:
    size = scale.scale_of(one)
    of_all = size.friction / np.hypot(size.rigid, size.friction)
    assert of_all.min() > 0.12
    assert of_all.max() < 0.7
    assert (one.friction.breakaway >= one.friction.coulomb).all()


def test_all_kinds_of_friction_and_arms_take_turns() -> None:
    made = [arm(seed) for seed in SEEDS]
    assert {m.friction.kind for m in made} == {"dry", "bristle", "smooth"}
    assert {m.joints for m in made} == {2, 4, 6, 7}
    assert arm.__wrapped__(SEEDS[0]).links == pytest.approx(made[0].links, abs=0)


def test_motions_keep_the_limits_and_rest_at_both_ends(one: ArmTruth) -> None:
    time = np.arange(0.0, DURATION + 1e-3, 2e-3)
    for seed in range(0, 80, 10):
        motion = FirstWorld().motion(one, seed, DURATION)
        q, v, a = motion.states(time)
        assert (q >= one.lower - 1e-9).all()
        assert (q <= one.upper + 1e-9).all()
        assert (np.abs(v) <= 1.01 * one.top_speed).all()
        assert np.abs(v[[0, -1]]).max() == 0
        assert np.abs(np.gradient(q, time, axis=0) - v).max() < 5e-3 * one.top_speed.max()
        assert np.abs(np.gradient(v, time, axis=0) - a)[2:-2].max() < 0.1 * np.abs(a).max()


def test_teaching_stops_and_a_chirp_moves_all_alike(one: ArmTruth) -> None:
    rng = np.random.default_rng(3)
    time = np.arange(0.0, DURATION, 1e-2)
    _, v, _ = motions.teaching(one, rng, DURATION, 1.0).states(time)
    assert (np.mean(v == 0, axis=0) > 0.05).all()
    assert (np.abs(v).max(axis=0) < 0.6 * one.top_speed).all()
    _, v, _ = motions.chirp(one, rng, DURATION, 1.0).states(time)
    assert np.linalg.matrix_rank(v / np.abs(v).max(axis=0), tol=1e-6) == 1


def test_a_background_is_two_to_ten_per_cent_of_the_torque(one: ArmTruth) -> None:
    rng = np.random.default_rng([9])
    shares = [background.share_of(one, scale.pilot(one, rng)) for _ in range(2)]
    assert np.min(shares) > 0.007
    assert np.median(shares) < 0.11


def test_effects_fit_the_arm(one: ArmTruth) -> None:
    ground = Ground(one, scale.scale_of(one), DURATION)
    for name in KINDS:
        hidden = draw(name, ground, np.random.default_rng(5))
        if hidden is None:
            assert name == "coupled_friction"
            continue
        assert np.isfinite(hidden.size)
        assert hidden.size != 0
        assert all(1 <= j <= one.joints for j in hidden.joints)
        assert scaled(hidden, 0.5).size == pytest.approx(hidden.size / 2)


def test_outside_causes_act_on_their_joint_and_grow_with_size(one: ArmTruth) -> None:
    time = np.arange(0.0, 2.0, 2e-3)
    rng = np.random.default_rng(7)
    size = scale.scale_of(one)
    q = rng.uniform(one.lower, one.upper, (len(time), one.joints))
    v = one.top_speed * rng.uniform(-1, 1, q.shape)
    torque = 3 * size.torque * rng.uniform(-1, 1, q.shape)
    for name in outside.MAKERS:
        cause = outside.outside(name, one, np.random.default_rng(11))
        effects, disturbances = cause.make(0.5)
        assert len(effects) + len(disturbances) == 1
        more = []
        for strength_ in (0.25, 0.5):
            for d in cause.make(strength_)[1]:
                resisted = [d.resist(t, *state) for t, *state in zip(time, q, v, strict=True)]
                added = np.zeros_like(q) if resisted[0] is None else np.array(resisted)
                delivered = np.array([d.deliver(t, *row) for t, *row in zip(time, v, torque, strict=True)])
                total = np.abs(added) + np.abs(delivered - torque) + np.abs(d.report(time, q, v, torque) - torque)
                assert [j + 1 for j in np.flatnonzero(total.max(axis=0) > 1e-12)] == list(cause.joints)
                more.append(float(np.sqrt(np.mean(total**2))))
        if more:
            assert more[1] > more[0] > 0


@dataclass(frozen=True)
class Claim:
    """A finding of some grade."""

    grade: str = "cause"
    rivals: tuple[object, ...] = field(default=())


def test_a_finding_of_lesser_grade_is_no_cause() -> None:
    bare = SimpleNamespace(rivals=())
    causes, rest = split(SimpleNamespace(findings=[bare, Claim(), Claim("hint")]))
    assert causes == [bare, Claim()]
    assert rest == [Claim("hint")]


def test_an_oracle_removes_what_the_tier_says() -> None:
    hidden = np.array([0.0, strength(15.0), strength(40.0)])
    assert Oracle.of(hidden, np.ones(3)).percent == pytest.approx(40.0)
    assert Oracle.of(hidden, np.ones(3)).joint == 2


def test_wilson_intervals() -> None:
    cell = share([True] * 8 + [False] * 2)
    assert (cell["low"], cell["high"]) == pytest.approx((49.02, 94.33), abs=0.02)


def test_a_file_is_read_as_it_was_meant(tmp_path: Path) -> None:
    time = np.arange(0.0, 5.0, 2e-3)
    q, v = np.column_stack([np.sin(time), np.cos(2 * time)]), np.column_stack([np.cos(time), -2 * np.sin(2 * time)])
    run = Run(time, q, v, np.gradient(v, time, axis=0), 10 * q, np.full_like(q, 25.0), None)
    sensors = Sensors(rate=250.0, dropped=0.05, encoder_step=1e-4, velocity_noise=1e-3, torque_noise=(0.1, 0.2))
    sensors.write(run, 1, tmp_path / "run.csv")
    recording = pid.load_recording(tmp_path / "run.csv")
    at = np.sin(recording.time)
    assert 0.02 < 1 - len(recording.time) / 1250 < 0.09
    assert np.abs(recording.q[:, 0] - at).max() < 0.51e-4
    assert recording.dq is not None
    assert np.std(recording.dq[:, 0] - np.cos(recording.time)) == pytest.approx(1e-3, rel=0.1)
    assert np.std(recording.torque[:, 1] - 10 * np.cos(2 * recording.time)) == pytest.approx(0.2, rel=0.1)
