"""The plain script of studies/peers is right where the truth is known, and its judge finds what no arm can have."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from tests.conftest import ROOT

FOLDER = ROOT / "studies" / "peers"


@pytest.fixture(scope="module")
def study() -> Iterator[dict[str, Any]]:
    """The scripts as modules, which find one another beside them."""
    sys.path.insert(0, str(FOLDER))
    names = ("program", "plain", "judged")
    yield {name: importlib.import_module(name) for name in names}
    sys.path.remove(str(FOLDER))
    for name in names:
        sys.modules.pop(name, None)


@pytest.fixture(scope="module")
def exact(study: dict[str, Any], ur5: pid.Robot) -> dict[str, Any]:
    """Rows of a UR5 with friction whose torque has no noise, and its parameters."""
    model = pin.buildModelFromXML(ur5.urdf)
    q, v, a = np.random.default_rng(0).uniform(-1, 1, (3, 400, 6))
    Y = study["plain"].regressor(model, q, v, a)
    links = np.concatenate([model.inertias[k].toDynamicParameters() for k in range(1, 7)])
    description = np.concatenate([links, np.zeros(24)])
    truth = np.concatenate([1.1 * links, np.full(6, 5.0), np.full(6, 3.0), np.full(6, 0.7), np.full(6, 0.2)])
    return {"Y": Y, "tau": Y @ truth, "description": description, "truth": truth, "states": (q, v, a)}


def test_the_regressor_is_that_of_the_arm(exact: dict[str, Any], ur5: pid.Robot) -> None:
    bodies = pid.make_effects(["rigid_body"])[0].regressor(ur5, pid.Signals.of_states(*exact["states"]))
    np.testing.assert_allclose(exact["Y"][:, :, :60], bodies, atol=1e-9)


@pytest.mark.parametrize("method", ["ols", "wls", "sdp"])
def test_exact_data_are_predicted_exactly(study: dict[str, Any], exact: dict[str, Any], method: str) -> None:
    tau = exact["tau"] + 1e-2 * np.random.default_rng(1).standard_normal(exact["tau"].shape)  # weights need a residual
    theta = study["plain"].fit(exact["Y"], tau, exact["description"], method)
    np.testing.assert_allclose(exact["Y"] @ theta, exact["tau"], atol=1e-3 * np.abs(exact["tau"]).max())


def test_links_of_the_semidefinite_program_are_possible_under_noise(
    study: dict[str, Any], exact: dict[str, Any]
) -> None:
    tau = exact["tau"] + 5.0 * np.random.default_rng(2).standard_normal(exact["tau"].shape)
    found = {}
    for method in ("wls", "sdp"):
        theta = study["plain"].fit(exact["Y"], tau, exact["description"], method)
        found[method] = study["judged"].violations(theta[:60], theta[60:66], theta[66:72])
    assert found["wls"]["links"], "the noise is too small to show the difference"
    assert not any(found["sdp"][kind] for kind in ("mass", "links", "viscous", "dry"))


def test_the_judge_finds_what_no_arm_can_have(study: dict[str, Any], ur5: pid.Robot) -> None:
    friction = np.array([1.0, 1.0, -0.5, 1.0, 1.0, 1.0])
    links = ur5.nominal.copy()
    links[10] *= -1  # the mass of link 2
    links[36] = links[34] + links[39] + 1.0  # Iyy of link 4 beyond the triangle inequality
    found = study["judged"].violations(links, friction, friction[::-1])
    assert found["mass"] == [2]
    assert found["links"] == [2, 4]
    assert (found["viscous"], found["dry"]) == ([3], [4])
    assert not study["judged"].violations(ur5.nominal, abs(friction), abs(friction))["links"]
