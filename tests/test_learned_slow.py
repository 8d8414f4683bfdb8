"""A torque that follows the position of a slow motion: it is one of few samples to a test that does not know it, and is found all the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.diagnosis.learned.search_and_learn import search_and_learn
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.rivals.same_torque import same_torque
from physident.estimation.identify import prepare_all
from tests.serial_arms import ARMS, urdf

pytestmark = pytest.mark.slow

Array = np.ndarray
TIME = np.arange(0.0, 20.0, 0.01)
STIFFNESS, PLACE = (
    3.0,
    0.2,
)  # N m/rad^3, rad: of a cable that pulls at the second joint with the third power of the angle
MEMORY = 4.0  # s, of a torque of the second joint that follows nothing


def slow_runs(
    folder: Path, seed: int, cable: float, wander: float, pace: float = 1.0
) -> tuple[pid.Robot, list[pid.Recording]]:
    """Four recordings of a planar arm by pinocchio, each slow and elsewhere: with a cable, and with a torque that wanders."""
    path = folder / "planar.urdf"
    path.write_text(urdf(ARMS["two"]))
    model = pin.buildModelFromXML(urdf(ARMS["two"]))
    data, runs = model.createData(), []
    for k in range(4):
        rng = np.random.default_rng([seed, k])
        omega, phase = pace * rng.uniform(0.3, 1.3, (4, 2)), rng.uniform(0, 2 * np.pi, (4, 2))
        middle = rng.uniform(-0.8, 0.8, 2)
        angle = TIME[:, None, None] * omega + phase
        q, v, a = (
            0.3 * part.sum(axis=1) for part in (np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle))
        )
        q = q + middle
        tau = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
        tau += 2.0 * v + 0.05 * rng.standard_normal(tau.shape)
        tau[:, 1] += cable * (q[:, 1] - PLACE) ** 3 + wander * wandering(rng)
        runs.append(pid.Recording.from_arrays(TIME, q, dq=v, effort=tau, source=f"{k}"))
    return pid.load_robot(path), runs


def wandering(rng: np.random.Generator) -> Array:
    """A torque (N,) of unit size that forgets where it was after some seconds (Ornstein and Uhlenbeck)."""
    keeps = np.exp(-(TIME[1] - TIME[0]) / MEMORY)
    steps, x = rng.standard_normal(len(TIME)), np.zeros(len(TIME))
    x[0] = steps[0]
    for k in range(1, len(x)):
        x[k] = keeps * x[k - 1] + np.sqrt(1 - keeps**2) * steps[k]
    return x


def missing(robot: pid.Robot, runs: list[pid.Recording]) -> pid.Diagnosis:
    return pid.diagnose_motion(pid.identify(robot, runs[:3]), runs[:3], runs[3:])


@pytest.mark.parametrize("seed", [2, 10, 12])
def test_a_slow_cable_is_a_curve_over_position(seed: int, tmp_path: Path) -> None:
    robot, runs = slow_runs(tmp_path, seed, STIFFNESS, 0.0)
    found = missing(robot, runs)
    (cause,) = found.causes
    assert (cause.effect, cause.joints) == ("learned_position", (2,))
    assert cause.stability is not None
    assert cause.stability > 0.9
    (band,) = cause.curves
    x, torque = np.array(band.x), np.array(band.torque)
    q = np.concatenate([run.q[:, 1] for run in runs[:3]])
    seen = (x > np.quantile(q, 0.02)) & (x < np.quantile(q, 0.98))
    apart = torque - STIFFNESS * (x - PLACE) ** 3
    others = np.column_stack([np.ones(len(x)), np.sin(x), np.cos(x)])[seen]  # an offset and gravity of the model
    apart = apart[seen] - others @ np.linalg.lstsq(others, apart[seen], rcond=None)[0]
    assert np.abs(apart).max() < 0.15 * STIFFNESS * np.ptp((x[seen] - PLACE) ** 3)


@pytest.mark.parametrize("seed", range(4))
def test_a_slow_torque_that_follows_nothing_is_no_curve(seed: int, tmp_path: Path) -> None:
    robot, runs = slow_runs(tmp_path, seed, 0.0, 1.0)
    found = missing(robot, runs)
    assert not found.causes
    assert found.verdict == "unexplained"


@pytest.mark.parametrize("seed", [0, 3])
def test_a_curve_over_time_does_not_stand_for_one_over_position(seed: int, tmp_path: Path) -> None:
    """On one slow motion it makes nearly the same torque, on any other it does not."""
    robot, runs = slow_runs(tmp_path, seed, STIFFNESS, 0.0, 0.15)
    estimate = pid.identify(robot, runs[:3])
    signals = prepare_all(robot, runs[:3], estimate.filter)
    found = search_and_learn(state_problem("missing", estimate, signals, estimate.filter, 0)).last.hypothesis
    assert ("learned_time", (2,)) in {c.key for c in found.data.candidates}
    same = same_torque(found)[("learned_position", (2,))]
    assert not [c for c in same if c.name == "learned_time"]
