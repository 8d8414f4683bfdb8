"""physident identify: a model from recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    GearRatiosOption,
    JointsOption,
    LockOption,
    RateOption,
    Recordings,
    RobotOption,
    ToolOption,
    TopicOption,
    effects_of,
    filter_of,
    layout_of,
    robot_of,
)


@app.command(short_help="Identify a model from recordings.")
def identify(
    recordings: Recordings,
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The model to write (JSON).")],
    robot: RobotOption = None,
    joints: JointsOption = None,
    lock: LockOption = None,
    tool: ToolOption = None,
    gear_ratios: GearRatiosOption = None,
    effects: Annotated[
        str | None, typer.Option("--effects", metavar="EFFECTS", help="Effects, separated by commas.")
    ] = None,
    method: Annotated[
        str,
        typer.Option(
            "--method",
            metavar="NAME",
            help="wls (joints weighted by their residuals), ols, robust, or physical (an arm that can exist).",
        ),
    ] = "wls",
    prior: Annotated[
        str,
        typer.Option("--prior", metavar="NAME", help="With --method physical: entropic, nominal or none."),
    ] = "entropic",
    prior_weight: Annotated[
        str | None,
        typer.Option(
            "--prior-weight",
            metavar="NUMBER|auto",
            help="1 means nominal links known to a factor of e; auto chooses by left-out recordings.",
        ),
    ] = None,
    loss: Annotated[
        str,
        typer.Option("--loss", metavar="NAME", help="With --method physical: squares, or huber against outliers."),
    ] = "squares",
    total_mass: Annotated[
        float | None,
        typer.Option("--total-mass", metavar="KG", help="With --method physical: mass of all moving links [kg]."),
    ] = None,
    columns: ColumnsOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
    json_out: Annotated[
        Path | None,
        typer.Option("--json", metavar="FILE", help="Also write parameters with units and confidence intervals."),
    ] = None,
) -> None:
    """Identify a robot's dynamics from recordings and write the model."""
    from physident.estimation.estimators import estimator_from_options
    from physident.estimation.identify import identify as run
    from physident.export.parameters import parameters_of
    from physident.files import write_json
    from physident.outputs import together

    estimator = estimator_from_options(method, prior, prior_weight, loss, total_mass)
    check_outputs([*recordings, robot], out, json_out)
    arm = robot_of(robot, joints, lock, tool, gear_ratios)
    layout = layout_of(columns, topic, rate)
    loaded = read_recordings(recordings, layout, drive_gains, joints=arm.joint_names)
    with busy("identifying"):
        estimate = run(arm, loaded, effects_of(effects), estimator, filter_of(cutoff), layout)
    with together():
        estimate.save(out)
        if json_out is not None:
            write_json(json_out, parameters_of(estimate))
    typer.echo(repr(estimate))
    typer.echo(f"written: {out}")
