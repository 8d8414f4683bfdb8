"""physident base-parameters: the parameters of a robot that its torques depend on."""

from __future__ import annotations

from typing import Annotated

import typer

from physident.cli.app import app, check_outputs, write_result
from physident.cli.options import (
    JointsOption,
    JsonOption,
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
    json_out: JsonOption = None,
) -> None:
    """Print a robot's base parameters: the combinations of parameters that its torques depend on."""
    from physident.dynamics.model import Model
    from physident.effects.catalogue import make_effects
    from physident.identifiability.base_parameters import find_base_parameters as run

    check_outputs([robot], json_out)
    arm, chosen = robot_of(robot, joints, lock, tool), make_effects(names_of(effects))
    base = run(arm, chosen)
    nominal = base.values(Model.nominal(arm, chosen).theta)
    rows = [{"expression": text, "nominal": float(x)} for text, x in zip(base.expressions(), nominal, strict=True)]
    write_result(json_out, "base_parameters", {"robot": arm.name, "parameters": len(base.columns), "base": rows})
    typer.echo(repr(base))
