"""physident compare: the gain of one model over another on held-out recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings, write_result
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    IncludeFittedOption,
    JsonOption,
    RateOption,
    TopicOption,
    layout_of,
    plot_option,
)
from physident.errors import InputError


@app.command(short_help="Compare the errors of two models.")
def compare(
    model: Annotated[list[Path], typer.Option("--model", metavar="FILE...", help="Two models: before, and after.")],
    on: Annotated[
        list[str],
        typer.Option("--on", metavar="RECORDING...", help="Recordings to compare on, up to the next option."),
    ],
    json_out: JsonOption = None,
    plot: Annotated[Path | None, plot_option("both residuals")] = None,
    include_fitted: IncludeFittedOption = False,
    columns: ColumnsOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Print the errors of two models on the same recordings, and the gain of the second over the first."""
    from physident.estimation.estimate_file import load_estimate
    from physident.outputs import together
    from physident.validation.scores import compare as run

    if len(model) != 2:
        raise InputError(f"{len(model)} models given, expected two: --model before.json after.json")
    check_outputs([*on, *model], json_out, plot=plot)
    before, after = (load_estimate(path).with_cutoff(cutoff) for path in model)
    layout = layout_of(columns, topic, rate, before.layout)
    recordings = read_recordings(on, layout, drive_gains, joints=before.model.robot.joint_names)
    with busy("comparing"):
        gain = run(before, after, recordings, include_fitted)
    with together():
        write_result(json_out, "gain", gain.as_dict())
        if plot is not None:
            from physident.graphics.figures.residual import plot_residuals
            from physident.validation.comparison import predict_pair

            pair = predict_pair(before, after, recordings, before.filter, before.drive_gains)
            plot_residuals(pair, before.model.robot, plot)
    typer.echo(repr(gain))
