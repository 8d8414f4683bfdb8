"""Friction with a memory: what builds up over a part of a degree is presliding, what needs six degrees is something else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.grading.one_story import REPLACED
from tests.serial_arms import ARMS, swung, urdf

pytestmark = pytest.mark.slow

LEVEL = 8.0  # N m


def rubbing(run: pid.Recording, joint: int, travel: float) -> pid.Recording:
    """A recording whose joint also drags a spring that slips once it is stretched by ``travel`` [rad]: a Maxwell slip element."""
    stretch, stretched = 0.0, []
    for step in np.diff(run.q[:, joint - 1], prepend=run.q[0, joint - 1]):
        stretch = float(np.clip(stretch + step, -travel, travel))
        stretched.append(stretch)
    more = np.zeros_like(run.effort)
    more[:, joint - 1] = LEVEL / travel * np.array(stretched)
    return replace(run, effort=run.effort + more)


@pytest.mark.parametrize(("travel", "grade"), [(0.01, "cause"), (0.1, "contribution")])
def test_only_a_short_memory_is_presliding(
    travel: float, grade: str, healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    """Six degrees are no bristle of a gear: the name stands for another law, and the text says why it is no cause."""
    found = pid.diagnose_motion(healthy_estimate, [rubbing(run, 3, travel) for run in healthy_runs[2:]])
    (finding,) = (f for f in found.findings if f.effect == "presliding_hysteresis")
    assert (finding.joints, finding.grade) == ((3,), grade), repr(found)
    (distance,) = (v for v in finding.parameters if v.name == "distance")
    if grade == "cause":
        # after a reversal a spring lacks twice its level on a straight line over twice its travel, an exponential of as much area over its distance
        assert distance.value == pytest.approx(travel, rel=0.15)
        (stiffness,) = (v for v in finding.parameters if v.name != "distance")
        assert stiffness.value * distance.value == pytest.approx(LEVEL, rel=0.05)
    else:
        takes, leaves = finding.takes_percent, finding.leaves_percent
        assert takes is not None
        assert leaves is not None
        assert takes > leaves  # the size alone would make it a cause
        assert "its distance lies at the end of the range searched" in " ".join(repr(found).split())


VISCOUS, DRY = np.array([3.5, 1.6]), np.array([1.8, 0.9])  # N m s/rad, N m
TRAVEL = 0.008  # rad


def gear(number: int, more: float) -> pid.Recording:
    """Twenty seconds of two joints, by pinocchio, whose dry friction on joint 2 is a Maxwell slip element of so many times its level."""
    rng, time = np.random.default_rng(number), np.arange(0.0, 20.0, 0.004)
    q, v, tau = swung(rng, time)
    stretch, stretched = 0.0, []
    for step in np.diff(q[:, 1], prepend=q[0, 1]):
        stretch = float(np.clip(stretch + step, -TRAVEL, TRAVEL))
        stretched.append(stretch / TRAVEL)
    tau += VISCOUS * v + DRY * np.column_stack([np.clip(v[:, 0] / 1e-4, -1, 1), more * np.array(stretched)])
    return pid.Recording.from_arrays(
        time, q, dq=v, effort=tau + 0.03 * rng.standard_normal(tau.shape), source=f"{number} {more}"
    )


@pytest.mark.parametrize("more", [1.0, 0.5])
def test_what_builds_up_in_the_place_of_coulomb_friction_is_no_loss_of_it(more: float, tmp_path: Path) -> None:
    """A simulation with the right levels lacks the memory alone; where the level is another one, the Coulomb friction is wrong, too."""
    (tmp_path / "two.urdf").write_text(urdf(ARMS["two"]))
    nominal = pid.Model.nominal(pid.load_robot(tmp_path / "two.urdf"))
    theta = np.array(nominal.theta)
    for name, values in (("viscous_friction", VISCOUS), ("coulomb_friction", DRY)):
        for j, value in enumerate(values, 1):
            theta[[c.name for c in nominal.columns].index(f"{name}_{j}")] = value
    simulated = pid.Model(nominal.robot, nominal.effects, theta)
    found = pid.diagnose_motion(simulated, [gear(1, more), gear(2, more)])
    grades = {(f.effect, f.joints): (f.grade, f.no_cause) for f in found.findings}
    assert grades["presliding_hysteresis", (2,)][0] == "cause"
    told = grades.get(("coulomb_friction", (2,)), ("", ""))
    assert told == (("contribution", REPLACED) if more == 1.0 else ("cause", ""))
