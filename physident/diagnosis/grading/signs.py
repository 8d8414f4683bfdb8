"""Whether an effect has the same sign in every recording: one that pushes here and pulls there is no property of the arm."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.physical_signs import SIGN_STANDARD_ERRORS

Array = NDArray[np.float64]
OPPOSITE = "its sign changes between recordings"


def amplitudes(hypothesis: Hypothesis, accepted: AcceptedEffect) -> tuple[Array, Array]:
    """By which factor (recordings,) each recording alone would scale an accepted effect's torque, all else as it is, and the
    standard error of that factor; the factor is zero and its error infinite where a recording does not show the effect."""
    at = next(i for i, one in enumerate(hypothesis.accepted) if one is accepted)
    columns = hypothesis.columns(accepted.candidate, accepted.effect)
    values, fit = hypothesis.effect_values[at], hypothesis.fit
    torque = fit.weights * columns.torque(values)
    recording = hypothesis.data.regressor.recording
    power = np.bincount(recording, np.sum(torque**2, axis=1))
    agreement = np.bincount(recording, np.sum(torque * (fit.residual * fit.weights + torque), axis=1))
    seen = power > 0
    safe = np.where(seen, power, 1.0)
    factor = np.where(seen, agreement / safe, 0.0)
    before = fit.residual * fit.weights
    after = (
        before - (factor[recording] - 1)[:, None] * torque
    )  # the noise is what is left when each recording has its own
    noise = np.sum(after**2, axis=0) / np.maximum(np.sum(before**2, axis=0), 1e-300)
    spread = np.bincount(recording, np.sum(torque**2 * noise, axis=1))
    return factor, np.where(seen, np.sqrt(spread) / safe, np.inf)


def changes_sign(hypothesis: Hypothesis, accepted: AcceptedEffect) -> bool:
    """Whether some recording shows an accepted effect with the opposite sign, beyond what noise does."""
    if accepted.candidate is CONTACT:
        return False
    factor, error = amplitudes(hypothesis, accepted)
    return bool((factor < -SIGN_STANDARD_ERRORS * error).any())
