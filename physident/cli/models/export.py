"""physident export: an identified model for simulators and other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app, check_outputs
from physident.cli.options import MeshesOption, ModelOption
from physident.errors import warn


@app.command(short_help="Write a model as URDF, MJCF, JSON, Python, C or CasADi.")
def export(
    model: ModelOption,
    urdf: Annotated[
        Path | None, typer.Option("--urdf", metavar="FILE", help="Write the URDF with identified values.")
    ] = None,
    mjcf: Annotated[
        Path | None,
        typer.Option("--mjcf", metavar="FILE", help="Write MJCF for MuJoCo; with --patch, the patched copy."),
    ] = None,
    patch: Annotated[
        Path | None,
        typer.Option("--patch", metavar="FILE", help="Your own MJCF: only the model's values are replaced in it."),
    ] = None,
    callback: Annotated[
        Path | None,
        typer.Option(
            "--callback", metavar="FILE", help="Write the effects that MJCF lacks as a Python callback for MuJoCo."
        ),
    ] = None,
    json_out: Annotated[
        Path | None,
        typer.Option("--json", metavar="FILE", help="Write parameters with units and confidence intervals."),
    ] = None,
    python: Annotated[
        Path | None, typer.Option("--python", metavar="FILE", help="Write a function torque(q, v, a) in NumPy.")
    ] = None,
    c: Annotated[
        Path | None, typer.Option("--c", metavar="FILE", help="Write torque, derivatives and regressor in C.")
    ] = None,
    casadi: Annotated[
        Path | None, typer.Option("--casadi", metavar="FILE", help="Write the torque as a CasADi function.")
    ] = None,
    meshes: MeshesOption = None,
) -> None:
    """Write an identified model as URDF, MJCF, a table of parameters (JSON), a Python function, C code or a CasADi function.

    The result lists what a format cannot express, and warns where the torque of the exported model is worse by more than a
    tenth on the training recordings."""
    from physident.estimation.estimate_file import load_estimate
    from physident.estimation.results.fitted import fitted_recordings
    from physident.export.formats import Targets, export_files
    from physident.export.held import loss_of_torque

    edited = patch if mjcf is None else None
    read = patch if mjcf is not None else None
    check_outputs([model, read], urdf, mjcf, callback, json_out, python, c, casadi, edited=edited)
    estimate = load_estimate(model)
    targets = Targets(
        urdf=urdf, mjcf=mjcf, patch=patch, callback=callback, json=json_out, python=python, c=c, casadi=casadi, meshes=meshes
    )  # fmt: skip
    exported = export_files(estimate, targets)
    typer.echo(exported.text)
    recordings = fitted_recordings(estimate) if exported.held else []
    for name, held in exported.held.items():
        if loss := loss_of_torque(estimate, held.model, recordings):
            warn(f"{name}: {loss}")
