"""Effects with a memory give the same columns in blocks as on a whole recording: what a value depends on is around it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.dynamics import column_structure
from physident.dynamics.regressor import build_regressor
from physident.effects import hysteresis
from physident.effects.catalogue import make_effects
from physident.effects.effect import Effect
from physident.estimation.identify import prepare_all
from physident.recordings.signals import Signals

WITH_MEMORY = [name for name, effect in pid.CATALOGUE.items() if not effect.pointwise]
BLOCK = 200  # samples: a few filters long


@pytest.fixture(scope="module")
def signals(healthy_runs: list[pid.Recording], ur5: pid.Robot) -> Signals:
    """A motion whose third joint rests for four of twenty seconds, and whose fourth never moves."""
    (one,) = prepare_all(ur5, healthy_runs[:1], pid.Filter())
    resting = (one.time > 8) & (one.time < 12)
    v, a = one.v.copy(), one.a.copy()
    v[resting, 2] = a[resting, 2] = 0.0
    v[:, 3] = a[:, 3] = 0.0
    return replace(one, v=v, a=a)


def columns(robot: pid.Robot, effect: Effect, signals: Signals) -> np.ndarray:
    found = build_regressor(robot, [*make_effects(["rigid_body"]), effect], [signals], pid.Filter())
    return np.concatenate([rows.plain[:, rows.columns >= 10 * robot.n].ravel() for rows in found.joints])


@pytest.mark.parametrize("name", WITH_MEMORY)
def test_blocks_hold_what_the_whole_holds(
    name: str, ur5: pid.Robot, signals: Signals, monkeypatch: pytest.MonkeyPatch
) -> None:
    effect = pid.CATALOGUE[name]()
    if effect.shape_parameters:
        effect = replace(effect, **{p.field: (p.grid[0],) * 6 for p in effect.shape_parameters})  # pyright: ignore[reportArgumentType]
    whole = columns(ur5, effect, signals)
    assert np.abs(whole).max() > 0
    for module in (column_structure, hysteresis):
        monkeypatch.setattr(module, "BLOCK", BLOCK)
    np.testing.assert_allclose(columns(ur5, effect, signals), whole, rtol=0, atol=1e-9 * np.abs(whole).max())


def test_a_bristle_is_forgotten_after_some_travel_and_not_before(
    ur5: pid.Robot, signals: Signals, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a joint at rest it is known only from where the joint last moved."""
    monkeypatch.setattr(hysteresis, "BLOCK", 50)
    effect = pid.CATALOGUE["presliding_hysteresis"](joints=(3,), distance=(0.001,))  # pyright: ignore[reportCallIssue]
    at = int(np.searchsorted(signals.time, 11.9))
    around = effect.around(ur5, signals, slice(at, at + 10))
    assert signals.time[around.start] < 8
    assert around.start > 0
    moving = int(np.searchsorted(signals.time, 5.0))
    assert moving - effect.around(ur5, signals, slice(moving, moving + 10)).start < 4 * 125
    still = pid.CATALOGUE["presliding_hysteresis"](joints=(4,), distance=(0.001,))  # pyright: ignore[reportCallIssue]
    assert still.around(ur5, signals, slice(at, at + 10)).start == 0
