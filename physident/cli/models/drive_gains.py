"""physident drive-gains: joint torque per motor current, from recordings with and without a known load."""

from __future__ import annotations

from typing import Annotated

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings, write_result
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    JointsOption,
    JsonOption,
    LockOption,
    RateOption,
    RobotOption,
    ToolOption,
    TopicOption,
    effects_of,
    filter_of,
    layout_of,
    robot_of,
)


@app.command("drive-gains", short_help="Identify joint torque per motor current.")
def drive_gains(
    unloaded: Annotated[
        list[str],
        typer.Option("--unloaded", metavar="RECORDING...", help="Recordings without the load, up to the next option."),
    ],
    loaded: Annotated[
        list[str],
        typer.Option("--loaded", metavar="RECORDING...", help="Recordings with the load, up to the next option."),
    ],
    load_mass: Annotated[
        float, typer.Option("--load-mass", metavar="KG", help="Mass of the load on the last link [kg].")
    ],
    robot: RobotOption = None,
    joints: JointsOption = None,
    lock: LockOption = None,
    tool: ToolOption = None,
    method: Annotated[
        str,
        typer.Option("--method", metavar="NAME", help="tls (total least squares), physical or ls (least squares)."),
    ] = "tls",
    effects: Annotated[
        str | None, typer.Option("--effects", metavar="EFFECTS", help="Effects of the arm, separated by commas.")
    ] = None,
    json_out: JsonOption = None,
    columns: ColumnsOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Identify the drive gains of an arm from motor currents with and without a load of known mass."""
    from physident.estimation.drive_gains.drive_gains import identify_drive_gains

    check_outputs([*unloaded, *loaded, robot], json_out)
    arm, chosen, filter = robot_of(robot, joints, lock, tool), effects_of(effects), filter_of(cutoff)
    layout = layout_of(columns, topic, rate)
    without, with_load = (read_recordings(paths, layout, None, joints=arm.joint_names) for paths in (unloaded, loaded))
    with busy("identifying"):
        found = identify_drive_gains(arm, without, with_load, load_mass, method, chosen, filter)
    write_result(json_out, "drive_gains", found.as_dict())
    typer.echo(repr(found))
