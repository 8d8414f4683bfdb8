"""physident drive-gains: joint torque per motor current, from recordings with and without a known load."""

from __future__ import annotations

from typing import Annotated

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings, write_result
from physident.cli.options import ColumnsOption, CutoffOption, JsonOption, RobotOption, effects_of, filter_of, robot_of


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
    method: Annotated[
        str,
        typer.Option("--method", metavar="NAME", help="tls (total least squares), physical or ls (least squares)."),
    ] = "tls",
    effects: Annotated[
        str | None, typer.Option("--effects", metavar="EFFECTS", help="Effects of the arm, separated by commas.")
    ] = None,
    json_out: JsonOption = None,
    columns: ColumnsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Identify the drive gains of an arm from motor currents with and without a load of known mass."""
    from physident.estimation.drive_gains.drive_gains import identify_drive_gains

    check_outputs([*unloaded, *loaded, robot], json_out)
    without, with_load = (read_recordings(paths, columns, None) for paths in (unloaded, loaded))
    arm, chosen, filter = robot_of(robot), effects_of(effects), filter_of(cutoff)
    with busy("identifying"):
        found = identify_drive_gains(arm, without, with_load, load_mass, method, chosen, filter)
    write_result(json_out, "drive_gains", found.as_dict())
    typer.echo(repr(found))
