"""Writes docs/reference/effects.md from the effect classes: equation, unit, family, signature and shape parameters."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import physident as pid
from physident.effects.classification import Scope
from physident.robots.kinematic_tree import LEVER

PAGE = Path(__file__).resolve().parent / "reference" / "effects.md"
LONGEST_GRID = 10  # values that are printed one by one
HEAD = """# The catalogue of effects

Each name below can be given to `identify` and `simulate`, can be part of a model, and can be found by a diagnosis.
This page is written by `docs/effects_page.py` from the classes in `physident/effects`;
[CONTRIBUTING.md](../../CONTRIBUTING.md#add-an-effect) shows how to add one.

In the equations, `sgn v` is the expected sign of the velocity: as sharp as the recording tells it, and at rest any value between the
sign before and the sign after ([friction near zero speed](../explanation/friction_near_zero_speed.md)). `tau_load` is the torque of the links' inertia and gravity, and
`tau_m` is the torque of all effects except those on the measurement, which act last. Columns that depend on the model's
torque are evaluated again with the current model until they no longer change. A shape parameter that is not given is
searched within the recordings: first on a grid, then refined, with all linear parameters refitted.
"""


def page() -> str:
    """The page's text."""
    return "\n".join([HEAD, *(_section(name, cls) for name, cls in pid.CATALOGUE.items())])


def _section(name: str, cls: Any) -> str:
    rows = [
        f"- **family** {cls.family.value}; **acts on** the {cls.acts_on}; **place** {_place(cls)}; **unit** {cls.unit}"
    ]
    if cls.signature:
        rows += [f"- **signature** {cls.signature}", f"- **mistaken for** {cls.mistaken_for}"]
    for shape in cls.shape_parameters:
        only = " only" if shape.discrete else ""
        slides = f"; where it slides at {LEVER:g} m for a radian" if "rad" in shape.unit else ""
        rows.append(
            f"- **shape parameter** `{shape.field}` [{shape.unit}], searched on {_grid(shape.grid)}{only}{slides}"
        )
    return f"## `{name}`\n\n{inspect.getdoc(cls) or ''}\n\n" + "\n".join(rows) + "\n"


def _place(cls: Any) -> str:
    return cls.scope.value if cls.scope is Scope.WHOLE_ARM else f"each {cls.scope.value}"


def _grid(values: tuple[float, ...]) -> str:
    if len(values) > LONGEST_GRID:
        return f"{values[0]:g}, {values[1]:g} ... {values[-1]:g}"
    return ", ".join(f"{value:g}" for value in values)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
