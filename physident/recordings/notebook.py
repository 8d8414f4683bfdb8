"""A recording as a notebook shows it."""

from __future__ import annotations

from typing import Any

import numpy as np

from physident.notebook import results_html


def recording_html(recording: Any) -> str:
    """A row for each joint of a ``Recording``: the ranges of its position [rad|m] and effort, and its largest speed [rad/s|m/s]."""
    r = recording
    dq = r.dq if r.dq is not None else np.gradient(r.q, r.time, axis=0)
    effort = "torque [N m]" if r.effort_kind == "torque" else "current [A]"
    head = ("joint", "smallest position [rad]", "largest", "largest speed [rad/s]", f"smallest {effort}", "largest")
    values = (r.q.min(axis=0), r.q.max(axis=0), np.abs(dq).max(axis=0), r.effort.min(axis=0), r.effort.max(axis=0))
    names = r.joint_names or range(1, r.n + 1)
    return results_html(
        repr(r), head, [(name, *(f"{x:.4g}" for x in row)) for name, *row in zip(names, *values, strict=True)]
    )
