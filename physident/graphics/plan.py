"""A planned motion to show, with the results of its design where it was designed."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from physident.errors import InputError
from physident.excitation.design import SCHEMA as DESIGN_SCHEMA
from physident.excitation.design import Design
from physident.excitation.motion.motion import SCHEMA, Motion
from physident.excitation.motion.trajectory import MAX_FILE, Trajectory, load_trajectory
from physident.files import naming, read_json

EXPECTED = "a motion or a design that physident design wrote"


@dataclass(frozen=True, eq=False)
class Plan:
    """A planned motion.

    ``progress`` is the condition number after each iteration of its design, first those of the ``generations`` of the
    genetic algorithm. ``design`` is the content of the design's JSON file, empty for a motion without one.
    """

    motion: Motion
    progress: tuple[float, ...] = ()
    design: dict[str, Any] = field(default_factory=dict)
    generations: int = 0


def plan_of(source: Plan | Motion | Design | str | Path, progress: tuple[float, ...] = ()) -> Plan:
    """The plan of a motion, a design, or a file of either; raises InputError for any other file."""
    if isinstance(source, Plan):
        return source
    if isinstance(source, Motion):
        return Plan(source, progress)
    if isinstance(source, Design):
        return _from_design(json.loads(json.dumps(source.as_dict())), progress)
    data = read_json(source, MAX_FILE, EXPECTED, SCHEMA, DESIGN_SCHEMA)
    if data["schema"] != DESIGN_SCHEMA:
        return Plan(load_trajectory(source), progress)
    with naming(source, "design", "design again"):
        return _from_design(data, progress)


def _from_design(data: dict[str, Any], progress: tuple[float, ...]) -> Plan:
    """The plan of a design's JSON content, with its progress where no other is given."""
    motion = Trajectory(**{key: value for key, value in data["trajectory"].items() if key != "kind"})
    saved = tuple(float(value) for value in data.get("progress", ()))
    plan_markdown(data)  # raises for margins that are not complete
    if not all(math.isfinite(value) and value > 0 for value in saved):
        raise InputError("progress has a value that is no condition number; expected positive numbers")
    generations = int(data.get("generations", 0))
    if not 0 <= generations <= len(saved):
        raise InputError(f"generations is {generations}, expected 0 to {len(saved)}, the length of its progress")
    return Plan(motion, progress or saved, data, 0 if progress else generations)


def plan_markdown(design: dict[str, Any]) -> str:
    """Markdown: the condition number that a design reached, and its limits, those with the smallest margin first."""
    lines = [
        f"**Condition number {float(design['condition']):.4g}** of {int(design['columns'])} columns,"
        f" {design['weighting']}; criterion {design['criterion']}.",
        "",
        "| limit | of | reached | allowed | unit |",
        "| --- | --- | --- | --- | --- |",
    ]
    margins = sorted(design["margins"], key=lambda m: float(m["margin"]) / max(abs(float(m["allowed"])), 1e-3))
    lines += [
        f"| {m['limit']} | {m['where']} | {float(m['reached']):.4g} | {float(m['allowed']):.4g} | {m['unit'].replace('^2', '²')} |"
        for m in margins
    ]
    return "\n".join(lines) + "\n"
