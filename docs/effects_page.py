"""Writes docs/reference/effects.md from the effect classes: name, equation, unit, signature, rivals, shape parameters."""

from __future__ import annotations

import inspect
from pathlib import Path

import physident as pid

PAGE = Path(__file__).resolve().parent / "reference" / "effects.md"
HEAD = """# The catalogue of effects

What a simulation of an arm can get wrong, and what a model can be made of: every name below can be given to `identify`, is
evaluated by `Model.torque`, acts in `simulate`, and is what a diagnosis may name. This page is made from the classes by
`docs/effects_page.py`.

`sgn v` is smooth everywhere: tanh(v / 0.01 rad/s). `tau_load` is the torque of inertia and gravity alone; `tau_m` that of all
effects but those on the measurement, which act last. Columns that depend on the model's torque are refreshed with the
current model until they settle. Shape parameters that are not given are found inside the fitting data: a grid, then a
refinement with all linear parameters refitted.
"""


def page() -> str:
    """The page's text."""
    parts = [HEAD]
    for name, cls in pid.CATALOGUE.items():
        doc = inspect.getdoc(cls) or ""
        first, _, rest = doc.partition("\n\n")
        parts.append(f"## `{name}`\n\n{first}\n")
        if rest:
            parts.append(f"{rest}\n")
        rows = [f"- **acts on** the {cls.acts_on}; **unit** {cls.unit}"]
        if cls.signature:
            rows += [f"- **shows as** {cls.signature}", f"- **mistaken for** {cls.rivals}"]
        rows += [
            f"- **shape** `{s.field}` [{s.unit}], searched on {_grid(s.grid)}" + (" only" if s.discrete else "")
            for s in cls.shapes
        ]
        parts.append("\n".join(rows) + "\n")
    return "\n".join(parts)


def _grid(values: tuple[float, ...]) -> str:
    if len(values) > 10:
        return f"{values[0]:g}, {values[1]:g} ... {values[-1]:g}"
    return ", ".join(f"{value:g}" for value in values)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
