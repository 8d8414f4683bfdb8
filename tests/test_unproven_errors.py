"""An error that no finding explains is told; one that a load further out makes on the joints before it is explained by the load."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import physident as pid
from tests.serial_arms import Joint, swinging, urdf

ARM = (
    Joint("0 0 1", mass=6.0, length=0.2), Joint("0 1 0", mass=5.0, length=0.4), Joint("0 1 0", "0 0 0.4", mass=3.0, length=0.3),
    Joint("0 1 0", "0 0 0.3", mass=1.0, length=0.1),
)  # fmt: skip
DRY, NOISE = np.array([4.0, 5.0, 3.0, 0.8]), 0.1  # N m
BOXED = (*ARM[:2], replace(ARM[2], mass=4.5), ARM[3])


def run(joints: tuple[Joint, ...], number: int) -> pid.Recording:
    """Twenty seconds by pinocchio, with dry friction that turns over a milliradian a second or so."""
    rng, time = np.random.default_rng(number), np.arange(0.0, 20.0, 0.004)
    q, v, tau = swinging(rng, time, joints, 0.4, (0.4, 4.0))
    tau += DRY * v / np.hypot(v, 0.002) + NOISE * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=str(number))


def test_a_box_on_the_forearm_explains_what_the_shoulder_errs_by(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(urdf(ARM))
    estimate = pid.identify(pid.load_robot(tmp_path / "arm.urdf"), [run(ARM, number) for number in (1, 2, 3)])
    found = pid.diagnose_motion(estimate, [run(BOXED, number) for number in (4, 5)])
    assert [(one.effect, one.joints) for one in found.causes] == [("link_inertia", (3,))], repr(found)
    assert found.before.rms[1] > 5 * found.after.rms[1]
    assert not [one for one in found.unexplained if one.is_unproven]
    assert found.verdict == "explained"
