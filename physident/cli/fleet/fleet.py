"""physident fleet: what has changed on every arm since its baseline, in every recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app, check_outputs, share_done, write_result
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    GearRatiosOption,
    JointsOption,
    JsonOption,
    LockOption,
    RateOption,
    Recordings,
    RobotOption,
    ToolOption,
    TopicOption,
    layout_of,
    parse_numbers,
    robot_of,
)


@app.command(short_help="Measure changes of many arms on a cluster.")
def fleet(
    recordings: Recordings,
    by: Annotated[
        str,
        typer.Option(
            "--by", metavar="PATTERN", help="The end of each path, suffix aside, with robot and date in braces."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FOLDER", help="The folder of the results, old and new.")],
    robot: RobotOption = None,
    joints: JointsOption = None,
    lock: LockOption = None,
    tool: ToolOption = None,
    gear_ratios: GearRatiosOption = None,
    baseline: Annotated[
        int, typer.Option("--baseline", metavar="N", help="Recordings of an arm that its baseline is identified from.")
    ] = 4,
    scheduler: Annotated[
        str | None, typer.Option("--scheduler", metavar="ADDRESS", help="An existing Dask cluster, tcp://host:8786.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option("--workers", metavar="N", min=1, help="Processes of this machine; by default all.")
    ] = None,
    columns: ColumnsOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
    json_out: JsonOption = None,
) -> None:
    """Measure in every new recording what has changed on its arm since the baseline, and add it to a data set."""
    from dataclasses import asdict

    from physident.fleet.run import run_fleet
    from physident.fleet.work import Reading

    check_outputs([*recordings, robot], json_out)
    arm = robot_of(robot, joints, lock, tool, gear_ratios)
    gains = None if drive_gains is None else parse_numbers(drive_gains, "--drive-gains")
    reading = Reading(columns=layout_of(columns, topic, rate), drive_gains=gains, cutoff=cutoff)
    with share_done("measuring") as show:
        result = run_fleet(
            arm, recordings, by, out, reading, baseline, scheduler, workers, done=lambda k, count: show(k / count)
        )
    write_result(json_out, "fleet_run", asdict(result))
    typer.echo(repr(result))
    typer.echo(f"written: {out}")
