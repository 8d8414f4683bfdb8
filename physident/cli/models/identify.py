"""physident identify: recordings in, a model out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    Recordings,
    RobotOption,
    effects_of,
    filter_of,
    robot_of,
)


@app.command(short_help="Recordings in, a model out.")
def identify(
    recordings: Recordings,
    out: Annotated[Path, typer.Option("--out", help="The model file to write (JSON).")],
    robot: RobotOption = None,
    effects: Annotated[str | None, typer.Option("--effects", help="Effects, separated by commas.")] = None,
    method: Annotated[
        str, typer.Option("--method", help="wls (each joint by its own residual), ols, robust or physical.")
    ] = "wls",
    prior: Annotated[str, typer.Option("--prior", help="With physical: entropic, nominal or none.")] = "entropic",
    prior_weight: Annotated[
        str | None,
        typer.Option("--prior-weight", help="1: nominal links known to a factor of e; auto: by left-out recordings."),
    ] = None,
    loss: Annotated[str, typer.Option("--loss", help="With physical: squares, or huber against outliers.")] = "squares",
    total_mass: Annotated[
        float | None, typer.Option("--total-mass", help="With physical: known mass of the moving links [kg].")
    ] = None,
    columns: ColumnsOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Identify a robot's dynamics from recordings and write the model."""
    from physident.estimation.estimators import estimator_from_options
    from physident.estimation.identify import identify as run

    estimator = estimator_from_options(method, prior, prior_weight, loss, total_mass)
    check_outputs([*recordings, robot], out)
    arm = robot_of(robot)
    loaded = read_recordings(recordings, columns, drive_gains)
    with busy("identifying"):
        estimate = run(arm, loaded, effects_of(effects), estimator, filter_of(cutoff), columns)
    estimate.save(out)
    typer.echo(repr(estimate))
    typer.echo(f"written: {out}")
