"""Unseen recordings judge a curve where it was learned: beyond its range it says nothing that they could refute."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

import physident as pid
from physident.diagnosis.result.saved import read_diagnosis
from tests.serial_arms import ARMS, urdf
from tests.sines import sines

pytestmark = pytest.mark.slow

Array = NDArray[np.float64]
JOINT = 2  # from 1
DRY, DRAG = np.array([1.5, 0.8]), np.array([1.0, 0.5])  # N m, N m s/rad
END = 0.9  # rad, where the diagnosed motions end on either side
AWAY = 1.4  # rad, by which another motion is moved: most of it is beyond their end


def rubbing(q: Array) -> Array:
    """Two narrow places at which a cable pushes, one of them where no diagnosed motion goes."""
    return 3.0 * np.exp(-(((q - 0.3) / 0.15) ** 2)) + 6.0 * np.exp(-(((q - 1.6) / 0.3) ** 2))


def nothing(q: Array) -> Array:
    return np.zeros_like(q)


def recorded(seed: int, cable: Callable[[Array], Array], centre: float = 0.0) -> pid.Recording:
    """Two joints with parallel axes along random motions, rigid torque by pinocchio, the last joint ``centre`` rad away."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 30.0, 0.004)
    model = pin.buildModelFromXML(urdf(ARMS["two"]))
    q, v, a = sines(rng, time, 3, 2, (0.5, 2.5), END / 3)
    q[:, JOINT - 1] += centre
    data = model.createData()
    tau = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
    tau += DRY * v / np.sqrt(v**2 + 0.01**2) + DRAG * v
    tau[:, JOINT - 1] += cable(q[:, JOINT - 1])
    tau += 0.05 * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"motion {seed}")


@pytest.fixture(scope="module")
def runs() -> list[pid.Recording]:
    return [recorded(seed, rubbing) for seed in (1, 2, 3)]


@pytest.fixture(scope="module")
def estimate(tmp_path_factory: pytest.TempPathFactory, runs: list[pid.Recording]) -> pid.Estimate:
    path: Path = tmp_path_factory.mktemp("arm") / "two.urdf"
    path.write_text(urdf(ARMS["two"]), encoding="utf-8")
    return pid.identify(pid.load_robot(path), runs, filter=pid.Filter(8.0))


def test_what_another_place_does_refutes_no_curve_but_it_is_not_handed_on(
    estimate: pid.Estimate, runs: list[pid.Recording], tmp_path: Path
) -> None:
    """With the curve the model errs by more on the whole of this holdout, and by less where the curve was learned."""
    found = pid.diagnose_motion(estimate, runs, [recorded(4, rubbing, AWAY)])
    (cause,) = found.causes
    assert (cause.effect, cause.joints) == ("learned_position", (JOINT,))
    assert cause.doubts == ()
    assert "% of their time the unseen recordings are beyond the range" in cause.advice
    assert "the extended model goes without it" in cause.advice
    assert cause.advice in " ".join(str(found).split())
    assert not cause.handed_on
    assert found.extended is None
    np.testing.assert_array_equal(found.after.rms, found.before.rms)
    found.save(tmp_path / "diagnosis.json")
    assert read_diagnosis(tmp_path / "diagnosis.json").causes == found.causes


def test_a_curve_that_helps_beyond_its_range_is_handed_on(estimate: pid.Estimate, runs: list[pid.Recording]) -> None:
    """Past the end of its range nothing pushes, as at its end, which is what the curve says there."""
    found = pid.diagnose_motion(estimate, runs, [recorded(7, lambda q: np.where(q > 0.6, 0.0, rubbing(q)), AWAY / 2)])
    (cause,) = found.causes
    assert "% of their time the unseen recordings are beyond the range" in cause.advice
    assert "goes without it" not in cause.advice
    assert cause.handed_on
    assert found.extended is not None
    assert found.after.rms[JOINT - 1] < found.before.rms[JOINT - 1]


def test_a_curve_that_is_wrong_where_it_was_learned_is_refuted(
    estimate: pid.Estimate, runs: list[pid.Recording]
) -> None:
    found = pid.diagnose_motion(estimate, runs, [recorded(5, nothing)])
    assert found.causes == ()
    (hint,) = (f for f in found.findings if f.effect == "learned_position")
    assert "not confirmed on unseen data" in hint.doubts
    assert "beyond the range" not in hint.advice


def test_a_holdout_within_the_range_confirms_it_without_a_word(
    estimate: pid.Estimate, runs: list[pid.Recording]
) -> None:
    found = pid.diagnose_motion(estimate, runs, [recorded(6, rubbing)])
    (cause,) = found.causes
    assert (cause.effect, cause.joints) == ("learned_position", (JOINT,))
    assert found.after.rms[JOINT - 1] < 0.3 * found.before.rms[JOINT - 1]
    assert "beyond the range" not in cause.advice
    assert cause.handed_on
