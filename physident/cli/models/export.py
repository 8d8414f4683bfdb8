"""physident export: an identified model for simulators and other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app, check_outputs
from physident.cli.options import ModelOption
from physident.errors import InputError


@app.command(short_help="Write a model as URDF, JSON or Python.")
def export(
    model: ModelOption,
    urdf: Annotated[
        Path | None, typer.Option("--urdf", metavar="FILE", help="Write the URDF with identified values.")
    ] = None,
    json_out: Annotated[
        Path | None,
        typer.Option("--json", metavar="FILE", help="Write parameters with units and confidence intervals."),
    ] = None,
    python: Annotated[
        Path | None, typer.Option("--python", metavar="FILE", help="Write a function torque(q, v, a) in NumPy.")
    ] = None,
) -> None:
    """Write an identified model as a URDF, a table of parameters (JSON) or a Python function."""
    from physident.errors import warn
    from physident.estimation.estimate_file import load_estimate
    from physident.export.held import loss_of_torque, training_recordings
    from physident.export.parameters import parameters_of
    from physident.export.python import python_of
    from physident.export.urdf import urdf_of
    from physident.files import json_text, write_text

    if urdf is None and json_out is None and python is None:
        raise InputError("nothing to write, expected --urdf out.urdf, --json out.json or --python out.py")
    check_outputs([model], urdf, json_out, python)
    estimate = load_estimate(model)
    texts: dict[Path, str] = {}  # all are complete before the first is written
    urdf_export = None if urdf is None else urdf_of(estimate.model)
    if urdf is not None and urdf_export is not None:
        texts[urdf] = urdf_export.text
    if json_out is not None:
        texts[json_out] = json_text(parameters_of(estimate))
    if python is not None:
        texts[python] = python_of(estimate.model)
    for path, text in texts.items():
        write_text(path, text)
    if urdf_export is not None:
        typer.echo(repr(urdf_export))
        if loss := loss_of_torque(estimate, urdf_export.held.model, training_recordings(estimate)):
            warn(loss)
    typer.echo(f"written: {', '.join(map(str, texts))}")
