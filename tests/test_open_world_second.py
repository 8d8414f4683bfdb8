"""The second open world: it is the same for the same seeds, physically possible, and knows nothing of the estimator."""

from __future__ import annotations

import ast
import pickle
import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

from studies.open_world_second import instruments, motions
from studies.open_world_second.outside import Outside
from studies.open_world_second.tool_causes import RockingFloor
from studies.open_world_second.usual import slides
from studies.open_world_second.world import SecondWorld
from tests.truth import ArmTruth, Disturbance, Motion

pytestmark = pytest.mark.slow

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "studies" / "open_world_second"
SEEDS = range(24)
DURATION = 14.0
WORLD = SecondWorld()
# what the catalogue of effects has, and may not be a kind of this world
CATALOGUE = {
    *("rotor_inertia", "viscous_friction", "coulomb_friction", "friction_asymmetry", "stribeck_friction"),
    *("nonlinear_viscous_friction", "load_dependent_friction", "presliding_hysteresis", "warm_up", "coupled_friction"),
    *("torque_constant", "torque_offset", "time_delay", "torque_ripple", "joint_spring", "joint_elasticity", "payload"),
    *("link_inertia", "gravity_tilt", "joint_zero_offset", "contact"),
}
STRUCTURAL = {"dropped_load", "backlash", "swinging_load", "flexible_base"}


@pytest.fixture(scope="module")
def arms() -> dict[str, ArmTruth]:
    """One arm of each design."""
    found: dict[str, ArmTruth] = {}
    for seed in SEEDS:
        arm = WORLD.arm(seed)
        found.setdefault(arm.name, arm)
    return found


def model_of(arm: ArmTruth) -> Any:
    model = pin.buildModelFromXML(arm.urdf)
    for number, row in enumerate(arm.links, 1):
        model.inertias[number] = pin.Inertia.FromDynamicParameters(row)
    return model


def along(arm: ArmTruth, motion: Motion, rate: float = 100.0) -> tuple[Array, Array, Array, Array]:
    """Times, positions, velocities and the torque of bodies, rotors and plain friction (N, n)."""
    time = np.arange(int(motion.duration * rate) + 1) / rate
    q, v, a = motion.states(time)
    model = model_of(arm)
    data = model.createData()
    torque = np.array([pin.rnea(model, data, *row) for row in zip(q, v, a, strict=True)]) + arm.rotor_inertia * a
    return time, q, v, torque + arm.friction.coulomb * np.sign(v) + arm.friction.viscous * v


def added(made: tuple[Disturbance, ...], time: Array, q: Array, v: Array, torque: Array) -> Array:
    """What disturbances add to the reported torque; what a drive fails to deliver is found by iteration."""
    real = torque.copy()
    for each in made:
        for i, now in enumerate(time):
            if (extra := each.resist(now, q[i], v[i])) is not None:
                real[i] += extra
    asked = real.copy()
    for i, now in enumerate(time):
        for _ in range(60):
            got = asked[i]
            for each in made:
                got = each.deliver(now, v[i], got)
            asked[i] = asked[i] + real[i] - got
            if np.abs(real[i] - got).max() < 1e-9:
                break
        else:
            raise AssertionError(f"no torque is found that delivers {real[i]}")
    for each in made:
        asked = each.report(time, q, v, asked)
    return asked - torque


def rms(values: Array) -> Array:
    return np.sqrt(np.mean(values**2, axis=0))


def test_every_design_is_drawn_with_every_friction() -> None:
    drawn = [WORLD.arm(seed) for seed in SEEDS]
    assert len({arm.name for arm in drawn}) == 6
    assert {arm.joints for arm in drawn} == {2, 3, 4, 5, 6, 7}
    assert {arm.friction.kind for arm in drawn} == {"dry", "bristle", "smooth"}


def test_seeds_reproduce() -> None:
    first, second = WORLD.arm(5), WORLD.arm(5)
    assert pickle.dumps(first) == pickle.dumps(second)
    assert first.urdf != WORLD.arm(6).urdf
    time = np.linspace(0, DURATION, 300)
    states = [WORLD.motion(first, 3, DURATION).states(time) for _ in range(2)]
    np.testing.assert_array_equal(states[0], states[1])
    causes = [WORLD.outside("dragging_brake", first, np.random.default_rng(4)).make(0.3) for _ in range(2)]
    assert causes[0] == causes[1]
    assert WORLD.conditions(8) == WORLD.conditions(8)


@pytest.mark.parametrize("seed", SEEDS)
def test_bodies_are_physical_and_differ_from_the_description(seed: int) -> None:
    arm = WORLD.arm(seed)
    model = pin.buildModelFromXML(arm.urdf)
    assert model.nq == model.nv == arm.joints
    assert model.existFrame(arm.tool)
    said = np.array([body.toDynamicParameters() for body in list(model.inertias)[1:]])
    for rows in (said, arm.links):
        for row in rows:
            assert np.linalg.eigvalsh(pin.PseudoInertia.FromDynamicParameters(row).toMatrix()).min() > 0
    assert (np.abs(arm.links[:, 0] / said[:, 0] - 1) < 0.6).all()
    assert np.abs(arm.links - said).max() > 0
    assert (arm.rotor_inertia > 0).all()
    friction = arm.friction
    for name in ("coulomb", "viscous", "stribeck_speed", "bristle_stiffness", "bristle_damping", "width"):
        assert (getattr(friction, name) > 0).all(), name
    assert (friction.breakaway >= friction.coulomb).all()
    # LuGre takes energy at all speeds up to the top: its damping stays below 4 coulomb / speed
    assert (friction.bristle_damping * arm.top_speed < 4 * friction.coulomb).all()
    assert (friction.width >= 5e-5).all()
    assert (friction.width <= 5e-2).all()


@pytest.mark.parametrize("kind", list(motions.KINDS))
def test_motions_rest_at_both_ends_and_keep_the_limits(kind: str, arms: dict[str, ArmTruth]) -> None:
    time = np.linspace(0, DURATION, 28001)
    for seed, arm in enumerate(arms.values()):
        motion = motions.KINDS[kind][1](arm, seed, DURATION)
        assert motion.duration == DURATION
        q, v, a = motion.states(time)
        assert (q >= arm.lower).all()
        assert (q <= arm.upper).all()
        assert (np.abs(v) <= 1.001 * arm.top_speed).all()
        assert (np.abs(a) <= 1.001 * arm.top_acceleration).all()
        ends = [0, 1, 2, -3, -2, -1]
        assert np.abs(v[ends]).max() < 1e-12
        assert np.abs(a[ends]).max() < 1e-12
        assert (np.ptp(q, axis=0) > 0.02 * (arm.upper - arm.lower)).any()
        # velocities and accelerations are those of the positions, and neither jumps
        step = time[1]
        np.testing.assert_allclose(np.gradient(q, step, axis=0)[1:-1], v[1:-1], atol=2e-3 * arm.top_speed.max())
        np.testing.assert_allclose(np.gradient(v, step, axis=0)[1:-1], a[1:-1], atol=2e-2 * arm.top_acceleration.max())


def test_background_is_a_small_share_of_the_torque(arms: dict[str, ArmTruth]) -> None:
    for arm in arms.values():
        assert 3 <= len(arm.background) <= 5
        shares = []
        for kind in ("fourier", "errands", "lissajous"):
            time, q, v, torque = along(arm, motions.KINDS[kind][1](arm, 31, DURATION))
            more = added(arm.background, time, q, v, torque)
            assert np.isfinite(more).all()
            shares.append(rms(more) / rms(torque))
        # 2 to 10 % on the motions that set it; others find more or less of it
        usual = np.mean(shares, axis=0)
        assert (usual > 0.007).all(), (arm.name, usual)
        assert (usual < 0.2).all(), (arm.name, usual)
        assert 0.02 < np.median(usual) < 0.12


@pytest.mark.parametrize("name", WORLD.OUTSIDE)
def test_outside_causes_are_felt_in_proportion(name: str, arms: dict[str, ArmTruth]) -> None:
    for number, arm in list(enumerate(arms.values()))[WORLD.OUTSIDE.index(name) % 2 :: 2]:
        cause = WORLD.outside(name, arm, np.random.default_rng([number, 9]))
        check_fields(cause, arm)
        effects, disturbances = cause.make(0.6 * cause.most)
        if effects:
            assert not disturbances
            assert effects[0].effect in STRUCTURAL
            assert cause.make(cause.most)[0][0].size > effects[0].size > 0
            continue
        shares = {0.3: 0.0, 1.0: 0.0}
        for part in shares:
            for kind in ("fourier", "errands"):
                time, q, v, torque = along(arm, motions.KINDS[kind][1](arm, 17, DURATION), 50.0)
                more = added(cause.make(part * cause.most)[1], time, q, v, torque)
                assert np.isfinite(more).all(), arm.name
                shares[part] = max(shares[part], float((rms(more) / rms(torque)).max()))
        assert shares[0.3] < shares[1.0], (arm.name, shares)
        # a cause at one place or speed may hardly be met by other motions than those that measured it
        assert 0.004 < shares[1.0] < 4, (arm.name, shares)


def check_fields(cause: Outside, arm: ArmTruth) -> None:
    assert {field.name for field in fields(cause)} == {"kind", "joints", "variable", "make", "most"}
    assert cause.kind not in CATALOGUE
    assert cause.variable in ("position", "velocity", "load", "time", "other")
    assert cause.joints
    assert all(1 <= joint <= arm.joints for joint in cause.joints)
    assert 0.02 < cause.most <= 0.6
    assert pickle.loads(pickle.dumps(cause)).kind == cause.kind


def test_channels_leave_gaps_where_they_are(arms: dict[str, ArmTruth]) -> None:
    arm = arms["swing"]
    time, q, v, torque = along(arm, WORLD.motion(arm, 2, DURATION))
    torque[300:320, 1] = np.nan
    made = [*arm.background]
    for name in ("transducer_hysteresis", "skewed_clock", "hot_magnets", "relaxing_seal"):
        made += WORLD.outside(name, arm, np.random.default_rng(1)).make(0.1)[1]
    for each in made:
        lost = np.isnan(each.report(time, q, v, torque))
        assert not lost[:, 0].any()
        assert 0 < lost.sum() <= 22  # a late clock writes a gap between rows


def test_the_rocking_floor_is_a_turned_weight(arms: dict[str, ArmTruth]) -> None:
    """Weight under gravity of the same strength that leans to where the cause says, less upright weight."""
    arm = arms["packer"]
    (floor,) = WORLD.outside("rocking_floor", arm, np.random.default_rng(3)).make(0.2)[1]
    q, now = (arm.lower + 2 * arm.upper) / 3, 2.7
    assert isinstance(floor, RockingFloor)
    x, y = floor.size * np.sin(2 * np.pi * now / np.array(floor.periods) + np.array(floor.phases))
    model = model_of(arm)
    upright = pin.computeGeneralizedGravity(model, model.createData(), q).copy()
    model.gravity.linear = 9.81 * np.array([x, y, -np.sqrt(1 - x * x - y * y)])
    leaning = pin.computeGeneralizedGravity(model, model.createData(), q)
    np.testing.assert_allclose(floor.resist(now, q, 0 * q), leaning - upright, atol=1e-9)


def test_instruments_are_ordinary(arms: dict[str, ArmTruth]) -> None:
    for seed, arm in enumerate(arms.values()):
        load = np.linspace(1.0, 2.0, arm.joints)
        drawn = instruments.draw(seed, load, slides(arm))
        assert drawn == instruments.draw(seed, load, slides(arm))
        assert 100 <= drawn["rate"] <= 1000
        assert drawn["velocity"] in ("measured", "absent")
        assert len(drawn["encoder_step"]) == len(drawn["velocity_noise"]) == len(drawn["torque_noise"]) == arm.joints
        assert (np.array(drawn["torque_noise"]) < 0.04 * load).all()
        assert 1e-6 < min(drawn["encoder_step"]) <= max(drawn["encoder_step"]) <= 2e-4
    assert slides(arms["packer"]).tolist() == [False, False, True, False]


def test_conditions_stay_in_a_workshop() -> None:
    warmer = np.array([WORLD.conditions(seed) for seed in range(200)])
    assert (warmer >= 0).all()
    assert (warmer <= 10).all()
    assert 0.2 < np.mean(warmer == 0) < 0.6


def test_the_page_names_every_cause() -> None:
    lines = (FOLDER / "README.md").read_text(encoding="utf-8").splitlines()
    told = {row.split("|")[1].strip(" `"): row.split("|") for row in lines if row.startswith("| `")}
    assert set(told) == set(WORLD.OUTSIDE)
    arm = WORLD.arm(1)
    for name, row in told.items():
        assert WORLD.outside(name, arm, np.random.default_rng(2)).variable == row[3].strip(), name
        assert set(re.findall(r"`(\w+)`", row[4])) <= CATALOGUE


def test_nothing_imports_the_estimator() -> None:
    for path in FOLDER.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                names = [node.module or ""]
            assert not any(name.split(".")[0] == "physident" for name in names), path.name
    code = (
        "import sys; from studies.open_world_second.world import SecondWorld; SecondWorld().arm(1); print(*sys.modules)"
    )
    loaded = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert not any(name.split(".")[0] == "physident" for name in loaded.split())
