"""physident base-parameters: the parameters of a robot that its torques depend on."""

from __future__ import annotations

from typing import Annotated

import typer

from physident.cli.app import app
from physident.cli.options import (
    JointsOption,
    LockOption,
    RobotOption,
    ToolOption,
    names_of,
    robot_of,
)


@app.command("base-parameters", short_help="List the parameters that torques depend on.")
def base_parameters(
    robot: RobotOption = None,
    joints: JointsOption = None,
    lock: LockOption = None,
    tool: ToolOption = None,
    effects: Annotated[
        str, typer.Option("--effects", metavar="EFFECTS", help="Effects, separated by commas.")
    ] = "rigid_body",
) -> None:
    """Print a robot's base parameters: the combinations of parameters that its torques depend on."""
    from physident.effects.catalogue import make_effects
    from physident.identifiability.base_parameters import find_base_parameters as run

    typer.echo(repr(run(robot_of(robot, joints, lock, tool), make_effects(names_of(effects)))))
