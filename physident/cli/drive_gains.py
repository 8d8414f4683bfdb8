"""physident drive-gains: what one ampere is worth in joint torque, from recordings with and without a known load."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from physident.cli.app import (
    ColumnsOption,
    CutoffOption,
    JsonOption,
    RobotOption,
    app,
    busy,
    check_outputs,
    read_recordings,
)
from physident.errors import InputError


@app.command("drive-gains", short_help="Motor current to joint torque.")
def drive_gains(
    unloaded: Annotated[list[str], typer.Option("--unloaded", help="Recording without the load; repeat for several.")],
    loaded: Annotated[list[str], typer.Option("--loaded", help="Recording with the load; repeat for several.")],
    load_mass: Annotated[float, typer.Option("--load-mass", help="Mass of the load on the last link [kg].")],
    robot: RobotOption = None,
    method: Annotated[str, typer.Option("--method", help="tls (errors in the currents), physical or ls.")] = "tls",
    effects: Annotated[str | None, typer.Option("--effects", help="Effects of the arm, separated by commas.")] = None,
    json_out: JsonOption = None,
    columns: ColumnsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Identify the drive gains of an arm from motor currents with and without a load of known mass."""
    from physident.effects import DEFAULT_EFFECTS
    from physident.estimation.drive_gains import identify_drive_gains
    from physident.files import write_text
    from physident.robot import load_robot
    from physident.signals import Filter

    if robot is None:
        raise InputError("no robot given, expected --robot with a built-in name (ur5), a .urdf or a DH table .toml")
    check_outputs([*unloaded, *loaded, robot], json_out)
    chosen = [name.strip() for name in effects.split(",") if name.strip()] if effects is not None else DEFAULT_EFFECTS
    without, with_load = (read_recordings(paths, columns, None) for paths in (unloaded, loaded))
    filter = Filter() if cutoff is None else Filter(cutoff)
    with busy("identifying"):
        found = identify_drive_gains(load_robot(robot), without, with_load, load_mass, method, chosen, filter)
    if json_out is not None:
        write_text(json_out, json.dumps(found.as_dict(), indent=1, allow_nan=False) + "\n")
    typer.echo(repr(found))
