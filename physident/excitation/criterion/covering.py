"""How much a motion adds to what is known of a curve, as a function of its information matrix."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.excitation.criterion.criterion import Criterion

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Covering(Criterion):
    """-log det(known + G) / (2 r), ``known`` (r, r) the information before the motion, positive definite.

    It is half the entropy that is left, as a mean over the curve's numbers: a place that was recorded before adds little.
    """

    known: Array

    name: ClassVar[str] = "covering"

    def values(self, G: Array) -> Array:
        return -0.5 * np.linalg.slogdet(G + self.known)[1] / len(self.known)

    def gradient(self, G: Array) -> tuple[float, Array]:
        slope = np.asarray(-0.5 / len(self.known) * np.linalg.inv(G + self.known), dtype=np.float64)
        return float(self.values(G)), slope
