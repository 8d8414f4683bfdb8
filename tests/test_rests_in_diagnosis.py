"""An arm that rests between moves: what dry friction holds there names no cause, and a change of friction is named all the same."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import physident as pid
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.result.extended_estimate import extended_estimate
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.diagnosis.statistics.intervals import uncertainty_of
from physident.estimation.identify import prepare_all
from tests.plant_mujoco.expected import PLANT
from tests.plant_mujoco.samples import sample
from tests.truth import ArmTruth

pytestmark = pytest.mark.slow

Array = NDArray[np.float64]
RATE = 125.0  # Hz
MOVE, PAUSE = 1.2, 1.3  # s
GREATER = 1.4  # times the friction of joint 1


@dataclass(frozen=True, eq=False)
class Moves:
    """From pose to pose (K, n) [rad] by polynomials of the fifth degree, with a pause at each."""

    poses: Array

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        return len(self.poses) * (MOVE + PAUSE)

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n)."""
        at = np.clip((time / (MOVE + PAUSE)).astype(int), 0, len(self.poses) - 1)
        u = np.clip((time - at * (MOVE + PAUSE) - PAUSE) / MOVE, 0.0, 1.0)[:, None]
        start, end = self.poses[at], self.poses[np.minimum(at + 1, len(self.poses) - 1)]
        way = end - start
        return (
            start + way * u**3 * (10 - 15 * u + 6 * u**2),
            way * 30 * u**2 * (1 - u) ** 2 / MOVE,
            way * 60 * u * (1 - u) * (1 - 2 * u) / MOVE**2,
        )


def recorded(arm: ArmTruth, folder: Path, seed: int) -> pid.Recording:
    """Nine poses by chance, as a controller with an encoder and a noisy torque sensor writes them down."""
    rng = np.random.default_rng(seed)
    run = PLANT.simulate(arm, Moves(rng.uniform(-1.2, 1.2, (9, arm.joints))))
    rows = slice(None, None, round(1 / RATE / (run.time[1] - run.time[0])))
    q = 5e-5 * np.round(run.q[rows] / 5e-5)
    tau = run.torque[rows] + 0.1 * rng.standard_normal(q.shape)
    path = folder / f"{seed}.csv"
    names = [f"{kind}_{j + 1}" for kind in ("q", "effort") for j in range(arm.joints)]
    np.savetxt(path, np.column_stack([run.time[rows], q, tau]), delimiter=",", header=",".join(["time", *names]), comments="")  # fmt: skip
    return pid.load_recording(path)


@dataclass(frozen=True, eq=False)
class Healthy:
    """An arm of two joints that sticks, three recordings of it in a folder, and the model that they give."""

    folder: Path
    arm: ArmTruth
    runs: list[pid.Recording]
    model: pid.Estimate

    def diagnosed(self, factor: float) -> pid.Diagnosis:
        """Two recordings after the friction of the first joint has grown by a factor, asked what is different."""
        friction, by = self.arm.friction, np.array([factor, 1.0])
        worn = replace(friction, coulomb=by * friction.coulomb, breakaway=by * friction.breakaway)
        folder = self.folder / f"{factor}"
        folder.mkdir()
        return pid.diagnose_motion(
            self.model, [recorded(replace(self.arm, friction=worn), folder, seed) for seed in (4, 5)]
        )


@pytest.fixture(scope="module")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> Healthy:
    folder, arm = tmp_path_factory.mktemp("moves"), sample("planar", "dry")
    (folder / "arm.urdf").write_text(arm.urdf)
    runs = [recorded(arm, folder, seed) for seed in (1, 2, 3)]
    return Healthy(folder, arm, runs, pid.identify(folder / "arm.urdf", runs))


def test_friction_that_has_grown_is_named_on_its_joint(healthy: Healthy) -> None:
    causes = [f for f in healthy.diagnosed(GREATER).findings if f.grade == "cause"]
    assert [(f.effect, f.joints) for f in causes] == [("coulomb_friction", (1,))]
    grown = (GREATER - 1) * healthy.arm.friction.coulomb[0]
    assert causes[0].parameters[0].change == pytest.approx(grown, rel=0.2)


def test_an_arm_that_rests_as_before_is_accused_of_nothing(healthy: Healthy) -> None:
    assert not [f for f in healthy.diagnosed(1.0).findings if f.grade == "cause"]


def test_a_model_extended_by_nothing_is_the_model(healthy: Healthy) -> None:
    """It is fitted as ``identify`` fits, rests held where friction is exhausted: gravity of joints that mostly rest depends on that."""
    signals = prepare_all(healthy.model.model.robot, healthy.runs, healthy.model.filter)
    hypothesis = settled_hypothesis(state_problem("missing", healthy.model, signals, healthy.model.filter, 0), ())
    again = extended_estimate(hypothesis, uncertainty_of(hypothesis), healthy.runs)
    np.testing.assert_allclose(again.theta, healthy.model.theta, rtol=1e-6, atol=1e-9)
