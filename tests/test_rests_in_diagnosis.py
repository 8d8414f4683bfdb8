"""An arm that rests between moves: what dry friction holds there names no cause, and a change of friction is named all the same."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import physident as pid
from tests.plant_mujoco.expected import PLANT
from tests.plant_mujoco.samples import sample
from tests.truth import ArmTruth

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


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Callable[[float], pid.Diagnosis]:
    """The diagnosis of an arm of two joints that sticks, after the friction of its first joint has grown by a factor."""
    folder = tmp_path_factory.mktemp("moves")
    arm = sample("planar", "dry")
    (folder / "arm.urdf").write_text(arm.urdf)
    model = pid.identify(folder / "arm.urdf", [recorded(arm, folder, seed) for seed in (1, 2, 3)])

    def diagnosed(factor: float) -> pid.Diagnosis:
        by = np.array([factor, 1.0])
        friction = replace(arm.friction, coulomb=by * arm.friction.coulomb, breakaway=by * arm.friction.breakaway)
        worn = replace(arm, friction=friction)
        (folder / f"{factor}").mkdir()
        return pid.diagnose_motion(model, [recorded(worn, folder / f"{factor}", seed) for seed in (4, 5)])

    return diagnosed


def test_friction_that_has_grown_is_named_on_its_joint(found: Callable[[float], pid.Diagnosis]) -> None:
    causes = [f for f in found(GREATER).findings if f.grade == "cause"]
    assert [(f.effect, f.joints) for f in causes] == [("coulomb_friction", (1,))]
    assert causes[0].parameters[0].change == pytest.approx((GREATER - 1) * sample().friction.coulomb[0], rel=0.2)


def test_an_arm_that_rests_as_before_is_accused_of_nothing(found: Callable[[float], pid.Diagnosis]) -> None:
    assert not [f for f in found(1.0).findings if f.grade == "cause"]
