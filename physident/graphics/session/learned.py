"""Learned curves of a diagnosis, each as a chart with its band."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from physident.diagnosis.result.findings import CurveBand
from physident.diagnosis.result.record import DiagnosisRecord
from physident.graphics import style
from physident.graphics.session import chart

if TYPE_CHECKING:
    import rerun as rr


def learned_curves(diagnosis: DiagnosisRecord | None) -> list[CurveBand]:
    """The learned curves of all findings."""
    return [] if diagnosis is None else [curve for finding in diagnosis.findings for curve in finding.curves]


def log_learned(rec: rr.RecordingStream, diagnosis: DiagnosisRecord) -> None:
    """Log each learned curve and the ends of its 95 % band under ``learned/K`` (K from 1)."""
    units = diagnosis.model.robot.torque_units
    for k, curve in enumerate(learned_curves(diagnosis), 1):
        x, low, high = (np.array(values) for values in (curve.x, curve.low, curve.high))
        axes = chart.Axes.about(np.concatenate([x, x]), np.concatenate([low, high]))
        chart.log_axes(
            rec, f"learned/{k}", axes, f"{curve.quantity} [{curve.unit}]", f"learned [{units[curve.joint - 1]}]"
        )
        for name, values in (("low", low), ("high", high)):
            chart.log_line(rec, f"learned/{k}/{name}", axes, x, values, style.SESSION_MEASURED)
        chart.log_line(rec, f"learned/{k}/curve", axes, x, np.array(curve.torque), style.MODELS[2])
