"""A diagnosis in memory: its record, and the extended model with what is known about its values."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.text import diagnosis_text
from physident.diagnosis.result.wording import numbered
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.files import write_json
from physident.notebook import results_html

FRAME = (
    "effect",
    "joint",
    "grade",
    "value",
    "change",
    "unit",
    "standard_error",
    "low",
    "high",
    "reduction_percent",
    "evidence",
    "stability",
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagnosis(DiagnosisRecord):
    """What is wrong with a model, where, how sure, and what it could be confused with; see ``DiagnosisRecord``.

    ``estimate`` is the extended model with the covariance of its values, None where nothing was found.
    """

    estimate: Estimate | None

    def save(self, path: str | Path) -> None:
        """Write the diagnosis as JSON, whole or not at all."""
        write_json(path, self.as_dict())

    def to_frame(self) -> Any:
        """The findings as a pandas frame with a row for each parameter: effect, joint, grade, value, change, unit, standard error,
        95 % interval, and the finding's reduction of the left-out RMS [%], its evidence and its stability.

        Raises InputError without pandas.
        """
        try:
            import pandas as pd
        except ImportError:
            raise InputError("to_frame needs pandas, which is not installed; expected pip install pandas") from None
        rows = [
            {
                "effect": f.effect,
                "joint": value.joint,
                "grade": f.grade,
                "value": value.value,
                "change": value.change,
                "unit": value.unit,
                "standard_error": value.std,
                "low": value.interval95[0],
                "high": value.interval95[1],
                "reduction_percent": f.gain.reduction_percent,
                "evidence": f.evidence,
                "stability": f.stability,
            }
            for f in self.findings
            for value in f.parameters
        ]
        names = [value.name for f in self.findings for value in f.parameters]
        return pd.DataFrame(rows, index=pd.Index(names, name="parameter"), columns=None if rows else list(FRAME))

    def __repr__(self) -> str:
        return diagnosis_text(self)

    def _repr_html_(self) -> str:
        head = (
            "cause",
            "joints",
            "grade",
            "values with 95 % intervals",
            "less RMS on left-out rows [%]",
            "it could also be",
        )
        rows = [
            (
                f.effect,
                numbered(f.joints),
                f.grade,
                "; ".join(
                    f"{v.name} {v.value:.4g} [{v.interval95[0]:.3g}, {v.interval95[1]:.3g}] {v.unit}"
                    for v in f.parameters
                ),
                f"{f.gain.reduction_percent:.1f}",
                ", ".join(f"{r.effect} {numbered(r.joints)}".rstrip() for r in f.rivals),
            )
            for f in self.findings
        ]
        return results_html(self.headline, head, rows, self.remainder)
