"""Cones hold for the model's sum: of a link with what is added to it, of a joint's friction over all its effects."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.estimation.physical.cones import physical_cones
from tests.test_identify import _recording


def test_a_tool_taken_off_is_physical_while_the_link_stays_a_body(ur5: pid.Robot) -> None:
    effects = pid.make_effects(["rigid_body", "payload"])
    cones = physical_cones(ur5, effects)
    assert len(cones.matrices) == 6
    last = pin.Inertia.FromDynamicParameters(ur5.link(6))
    half = pin.Inertia(last.mass / 2, last.lever, last.inertia / 2).toDynamicParameters()
    assert cones.broken(np.concatenate([ur5.nominal, -half])) == []
    assert cones.broken(np.concatenate([ur5.nominal, -3 * half])) == ["link 6 is not a rigid body"]


def test_the_physical_estimate_of_a_loaded_arm_is_a_body_in_sum(ur5: pid.Robot) -> None:
    run = _recording(ur5, 1, 0.3)
    estimate = pid.identify(
        ur5, [run], ["rigid_body", "viscous_friction", "coulomb_friction", "payload"], method=pid.Physical(resamples=0)
    )
    assert estimate.violations == ()
    links = physical_cones(ur5, estimate.model.effects).matrices
    for link in links:
        assert np.linalg.eigvalsh(link.at(estimate.theta))[0] >= -1e-9


@pytest.mark.parametrize(("exponent", "physical"), [(2.0, True), (0.5, False)])
def test_friction_dissipates_as_a_sum(exponent: float, physical: bool, ur5: pid.Robot) -> None:
    """A negative v |v| beside Coulomb friction is physical while their sum opposes the motion at every speed."""
    effects = (
        *pid.make_effects(["coulomb_friction"]),
        pid.CATALOGUE["nonlinear_viscous_friction"](joints=(2,), exponent=(exponent,)),
    )
    fastest = ur5.velocity_limit[1]
    bent = -0.9 * 5.0 / fastest**exponent  # takes nine tenths of the Coulomb friction at full speed
    theta = np.concatenate([np.full(6, 5.0), [bent if physical else 1.3 * bent]])
    assert (physical_cones(ur5, effects).broken(theta) == []) is physical
