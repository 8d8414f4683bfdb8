"""physident base-parameters: what any motion of a robot could show."""

from __future__ import annotations

from typing import Annotated

import typer

from physident.cli.app import RobotOption, app
from physident.errors import InputError


@app.command("base-parameters", short_help="What any motion could show.")
def base_parameters(
    robot: RobotOption = None,
    effects: Annotated[str, typer.Option("--effects", help="Effects, separated by commas.")] = "rigid_body",
) -> None:
    """Print a robot's base parameters: the combinations of parameters that its torques depend on."""
    from physident.base_parameters import find_base_parameters as run
    from physident.effects import make_effects
    from physident.robot import load_robot

    if robot is None:
        raise InputError("no robot given, expected --robot with a built-in name (ur5), a .urdf or a DH table .toml")
    names = [name.strip() for name in effects.split(",") if name.strip()]
    typer.echo(repr(run(load_robot(robot), make_effects(names))))
