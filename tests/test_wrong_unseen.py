"""Which errors on unseen recordings are no noise: each of the levels they are held against excuses an error by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.remainder.unexplained import Unexplained
from physident.diagnosis.result.errors import FAR, beyond_noise
from physident.diagnosis.result.findings import JointErrors

LEFT = 0.01  # N m, beside which the simulated arm's parameters are known to less
FAINT = dict.fromkeys(("lag_one", "memory", "white_memory", "slow", "peak", "velocity", "position", "load"), 0.0)


def left(rms: float) -> list[Unexplained]:
    return [Unexplained(joint=j, rms=rms, time=0.0, order=1.0, order_share=0.0, **FAINT) for j in range(1, 7)]


@pytest.mark.parametrize("times", [0.8, 1.2])
def test_an_error_far_above_every_level_is_wrong_unseen_and_each_level_excuses_it(
    healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording], times: float
) -> None:
    sure = replace(healthy_estimate, covariance=1e-12 * healthy_estimate.covariance)
    big = np.full(6, 10 * LEFT)
    errors = JointErrors(rms=times * FAR * big, relative=big)

    def wrong(
        rms: float = LEFT, floor: np.ndarray | None = None, own: float | None = None, model: pid.Estimate = sure
    ) -> tuple[int, ...]:
        changed = None if own is None else replace(sure, sigma=np.full(6, own))
        return beyond_noise(model, healthy_runs[:2], healthy_runs[2:3], errors, left(rms), floor, changed)

    everywhere = (1, 2, 3, 4, 5, 6)
    assert wrong() == everywhere
    assert wrong(own=LEFT) == everywhere
    excused = everywhere if times > 1 else ()
    assert wrong(rms=big[0]) == excused  # what the diagnosed recordings leave
    assert wrong(floor=big) == excused  # what does not repeat
    assert wrong(own=big[0]) == excused  # what the model left on its own recordings before the arm changed
    vague = replace(healthy_estimate, covariance=1e6 * np.array(healthy_estimate.covariance))
    assert wrong(model=vague) == ()  # what its values leave open


def test_noise_of_a_slower_recording_is_larger(
    healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    """A fifth of the rate lets the root of five times as much through the filter."""
    sure = replace(healthy_estimate, covariance=1e-12 * healthy_estimate.covariance)
    run = healthy_runs[2]
    slow = replace(
        run, time=run.time[::5], q=run.q[::5], effort=run.effort[::5], dq=None if run.dq is None else run.dq[::5]
    )
    big = np.full(6, FAR * 10 * LEFT)
    for times, told in ((1.8, ()), (2.7, (1, 2, 3, 4, 5, 6))):
        errors = JointErrors(rms=times * big, relative=big)
        assert beyond_noise(sure, healthy_runs[:2], [slow], errors, left(10 * LEFT), None, None) == told
    assert beyond_noise(
        sure, healthy_runs[:2], [run], JointErrors(rms=1.8 * big, relative=big), left(10 * LEFT), None, None
    )
