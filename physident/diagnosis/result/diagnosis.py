"""A diagnosis in memory: its record, and the extended model with what is known about its values."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.text import diagnosis_text
from physident.estimation.estimate import Estimate
from physident.files import write_json


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagnosis(DiagnosisRecord):
    """What is wrong with a model, where, how sure, and what it could be confused with; see ``DiagnosisRecord``.

    ``estimate`` is the extended model with the covariance of its values, None where nothing was found.
    """

    estimate: Estimate | None

    def save(self, path: str | Path) -> None:
        """Write the diagnosis as JSON, whole or not at all."""
        write_json(path, self.as_dict())

    def __repr__(self) -> str:
        return diagnosis_text(self)
