"""physident validate: how well a model predicts held-out recordings."""

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
    ModelOption,
    RateOption,
    Recordings,
    TopicOption,
    layout_of,
    plot_option,
)


@app.command(short_help="Measure a model's error on held-out recordings.")
def validate(
    recordings: Recordings,
    model: ModelOption,
    json_out: JsonOption = None,
    plot: Annotated[Path | None, plot_option("measured and predicted torque")] = None,
    include_fitted: IncludeFittedOption = False,
    columns: ColumnsOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Predict recordings with a model, and print the error of each joint."""
    from physident.estimation.estimate_file import load_estimate
    from physident.outputs import together
    from physident.validation.predictions import predict
    from physident.validation.scores import validate as run

    check_outputs([*recordings, model], json_out, plot=plot)
    estimate = load_estimate(model).with_cutoff(cutoff)
    layout = layout_of(columns, topic, rate, estimate.layout)
    loaded = read_recordings(recordings, layout, drive_gains, joints=estimate.model.robot.joint_names)
    with busy("predicting"):
        score = run(estimate, loaded, include_fitted)
    with together():
        write_result(json_out, "score", score.as_dict())
        if plot is not None:
            from physident.graphics.figures.recordings import plot_predictions

            robot = estimate.model.robot
            plot_predictions(predict(estimate, loaded), robot.joint_names, plot, robot.torque_units)
    typer.echo(repr(score))
