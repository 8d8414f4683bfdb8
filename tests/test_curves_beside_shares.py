"""A curve beside an effect that depends on the model's own torque: without a prior, curves would grow against gravity where no row counts."""

from __future__ import annotations

import numpy as np
import pytest

import physident as pid
from physident.effects.catalogue import CATALOGUE
from physident.effects.effect import Effect
from tests.plant import Arm, Sensors, hide, point_to_point, record

JOINT = 2  # it rests half of the time, and is held by gravity alone then


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[pid.Recording]:
    folder = tmp_path_factory.mktemp("resting")
    arm = hide(Arm(), "joint_spring", JOINT, 9.0)
    for seed in (1, 2):
        record(arm, point_to_point(seed), Sensors(), seed, step=4e-3).write_csv(folder / f"{seed}.csv")
    return [pid.load_recording(folder / f"{seed}.csv") for seed in (1, 2)]


@pytest.mark.parametrize(
    ("name", "joints"), [("torque_crosstalk", (1,)), ("torque_crosstalk", (6,)), ("load_dependent_friction", (JOINT,))]
)
def test_a_model_predicts_its_own_recordings_as_well_as_its_fit_says(
    ur5: pid.Robot, runs: list[pid.Recording], name: str, joints: tuple[int, ...]
) -> None:
    """Else the columns were those of another model than the one that was saved."""
    beside: list[str | Effect] = [CATALOGUE["learned_position"]((JOINT,)), CATALOGUE["learned_velocity"]((JOINT,))]
    default = ["rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction", "torque_offset"]
    estimate = pid.identify(ur5, runs, [*default, *beside, CATALOGUE[name](joints)], filter=8.0)
    measured = pid.validate(estimate, runs, include_fitted=True)
    np.testing.assert_allclose(measured.relative_all, estimate.relative, rtol=0.02)
