"""What a model leaves of its own recordings, and how much larger that is on a healthy arm's recordings that it was not fitted to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.agreement import theta_without_each
from physident.dynamics.model import Model
from physident.estimation.estimate import Estimate
from physident.estimation.results.predictions import predictions_of
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
FEWEST = 3  # recordings: of two that are left out one by one, a single one says how the model errs
RARE = 0.01  # of healthy arms err by more on any joint
OFTEN = 0.9  # of the joints of healthy arms err by no more
SMALLEST = 1e-12  # N m|N: recordings that are exact have a logarithm


@dataclass(frozen=True, kw_only=True, eq=False)
class OwnError:
    """The RMS (n,) [N m|N] that a model leaves of its own recordings; how many ``times`` (n,) as large it is at most on new ones of an arm on
    which nothing has changed, and the RMS ``often`` (n,) [N m|N] that nine of ten joints of such an arm do not exceed there; None where too few
    recordings tell. ``period`` [s] is the mean time between its samples."""

    rms: Array
    times: Array | None
    period: float
    often: Array | None = None

    @staticmethod
    def of(estimate: Estimate, own: Sequence[Signals], new: int) -> OwnError:
        """What a model's ``own`` recordings say of so many ``new`` ones.

        Each is left out, and predicted by the model that the others give. How the logarithms of these errors scatter, joint by joint and pooled
        over the joints, says how those of new recordings do (Student's t; Bonferroni over the joints).
        """
        from scipy.stats import t

        model, filter = estimate.model, estimate.filter
        rms, period = predictions_of(model, own, filter).rms, mean_period(own)
        if len(own) < FEWEST:
            return OwnError(rms=rms, times=None, period=period)
        left_out = [
            predictions_of(Model(model.robot, model.effects, theta), [one], filter).rms
            for theta, one in zip(theta_without_each(estimate, own), own, strict=True)
        ]
        logs = np.log(np.maximum(left_out, SMALLEST) / np.maximum(rms, SMALLEST))
        scatter = float(np.sqrt(np.mean(np.var(logs, axis=0, ddof=1))))
        spread, degrees = scatter * np.sqrt(1 / new + 1 / len(own)), len(rms) * (len(own) - 1)
        times, often = (
            np.exp(logs.mean(axis=0) + t.ppf(share, degrees) * spread) for share in (1 - RARE / len(rms), OFTEN)
        )
        return OwnError(rms=rms, times=times, period=period, often=often * rms)

    def louder(self, new: Sequence[Signals]) -> float:
        """By how much noise alone may be larger in new recordings: white noise through one filter has a power that falls with the rate."""
        return float(np.sqrt(max(1.0, mean_period(new) / self.period)))


def mean_period(signals: Sequence[Signals]) -> float:
    """Time [s] from one sample to the next, mean over recordings."""
    return float(np.mean([1 / one.rate for one in signals]))
