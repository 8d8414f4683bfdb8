"""The thresholds of a diagnosis: what an effect or a contact reaches by chance, and how much a finding must be worth.

Chance is measured on surrogates of the residual, which have no relation to the motion. The largest score over the whole
catalogue counts, so that many candidates do not make a finding more likely. The conditions that use these numbers are in
``acceptance``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.identifiability.visibility import VISIBLE

Array = NDArray[np.float64]
SURROGATES = 299  # the 99th percentile is then the third largest
LEVEL = 0.99  # of a hundred clean arms one is accused of an effect, and one of a contact
MIN_REDUCTION_PERCENT = 2.0  # of one joint's RMS: below, a true effect has no practical use


def effect_threshold(evidence: Array, visible_share: Array) -> float:
    """The evidence that an effect must exceed, from that of all candidates on surrogates (C, S).

    ``visible_share`` (C,) excludes candidates that these recordings cannot show.
    """
    return float(np.quantile(evidence[visible_share >= VISIBLE].max(axis=0), LEVEL))


def contact_threshold(evidence: Array) -> float:
    """The evidence that a contact must exceed, from that of the best contact on each surrogate (S,).

    It is separate because a contact may begin at any time: its luckiest beginning need not beat an effect's.
    """
    return float(np.quantile(evidence, LEVEL))
