"""physident design: the motion that excites the parameters of a robot or a model best."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from physident.cli.app import app, check_outputs, share_done
from physident.cli.options import (
    JointsOption,
    JsonOption,
    LockOption,
    MeshesOption,
    RobotOption,
    ToolOption,
    optional_robot,
    plot_option,
)
from physident.errors import InputError, warn

if TYPE_CHECKING:
    from physident.estimation.estimate import Estimate
    from physident.excitation.coverage import Coverage
    from physident.excitation.design import Design
    from physident.excitation.discrimination import Discrimination
    from physident.robots.robot import Robot

MAX_RATE = 1e5  # Hz, faster than any controller


@app.command(short_help="Design the motion to record.")
def design(
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The motion to write (physident.trajectory/1).")],
    robot: RobotOption = None,
    joints: JointsOption = None,
    lock: LockOption = None,
    tool: ToolOption = None,
    model: Annotated[
        Path | None, typer.Option("--model", metavar="FILE", help="A model, all of whose effects are excited.")
    ] = None,
    harmonics: Annotated[
        int, typer.Option("--harmonics", metavar="N", help="Harmonics of each joint's Fourier series.")
    ] = 5,
    base_frequency: Annotated[
        float | None,
        typer.Option(
            "--base-frequency",
            metavar="HZ",
            help="Base frequency [Hz]; default 0.15, 0.1 with --discriminate or --cover.",
        ),
    ] = None,
    periods: Annotated[
        int | None,
        typer.Option("--periods", metavar="N", help="Number of periods; default 1, 2 with --discriminate or --cover."),
    ] = None,
    limits: Annotated[
        str,
        typer.Option(
            "--limits",
            metavar="joint|all",
            help="joint: position, speed, acceleration; all: also torque, tool speed, table and self-collision.",
        ),
    ] = "all",
    criterion: Annotated[
        str | None, typer.Option("--criterion", metavar="NAME", help="condition (the default), d_optimal or a_optimal.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, metavar="N", help="The same seed gives the same motion.")] = 0,
    table: Annotated[
        float, typer.Option("--table", metavar="M", help="Height of the table in the base frame [m].")
    ] = 0.0,
    no_table: Annotated[bool, typer.Option("--no-table", help="Design without a table.")] = False,
    clearance: Annotated[
        float, typer.Option("--clearance", metavar="M", help="Distance between links and to the table [m].")
    ] = 0.02,
    meshes: MeshesOption = None,
    discriminate: Annotated[
        tuple[str, str] | None,
        typer.Option("--discriminate", metavar="A B", help="Separate these two rival effects instead."),
    ] = None,
    cover: Annotated[
        str | None,
        typer.Option(
            "--cover",
            metavar="EFFECT",
            help="Go where the curves of this learned effect of the model have not been instead.",
        ),
    ] = None,
    joint: Annotated[
        int | None, typer.Option("--joint", metavar="N", help="With --discriminate or --cover: only this joint.")
    ] = None,
    noise: Annotated[
        float | None,
        typer.Option(
            "--noise", metavar="NM", help="With --discriminate: RMS of the torque noise after the filter [N m]."
        ),
    ] = None,
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Also write time, q, dq, ddq as a table.")
    ] = None,
    rate: Annotated[float, typer.Option("--rate", metavar="HZ", help="Rate of that table [Hz].")] = 125.0,
    json_file: JsonOption = None,
    plot: Annotated[Path | None, plot_option("the motion")] = None,
) -> None:
    """Design a motion, at rest at both ends and within the limits, that excites all parameters best."""
    from physident.excitation.coverage import Coverage
    from physident.excitation.discrimination import Discrimination
    from physident.files import write_json
    from physident.outputs import together

    _check_aims(criterion, discriminate, cover, joint, noise)
    check_outputs([robot, model], out, csv, json_file, plot=plot)
    if not 0 < rate <= MAX_RATE:
        raise InputError(f"--rate is {rate} Hz, expected a positive number up to {MAX_RATE:g}")
    source = _source(optional_robot(robot, joints, lock, tool), model)
    with share_done("designing") as progress:
        settings: dict[str, Any] = {
            "limits": limits, "harmonics": harmonics, "seed": seed, "table": None if no_table else table,
            "clearance": clearance, "meshes": meshes, "progress": progress,
        }  # fmt: skip
        # without these options, the defaults of either function
        settings |= {} if base_frequency is None else {"base_frequency": base_frequency}
        settings |= {} if periods is None else {"periods": periods}
        result = _designed(source, criterion, discriminate, cover, joint, noise, settings)
    plan = result.design if isinstance(result, Discrimination | Coverage) else result
    with together():
        if csv is not None:
            plan.trajectory.write_csv(csv, rate)
        if plot is not None:
            from physident.graphics.figures.motion import plot_motion

            plot_motion(plan.trajectory, plot)
        if json_file is not None:
            write_json(json_file, result.as_dict())
        plan.trajectory.save(out)
    if plan.manipulability.warning:
        warn(plan.manipulability.warning)
    typer.echo(
        f"{result!r}\nwritten: {', '.join(str(path) for path in (out, csv, json_file, plot) if path is not None)}"
    )


def _check_aims(
    criterion: str | None,
    discriminate: tuple[str, str] | None,
    cover: str | None,
    joint: int | None,
    noise: float | None,
) -> None:
    aims = {"--criterion": criterion, "--discriminate": discriminate, "--cover": cover}
    given = [name for name, value in aims.items() if value is not None]
    if len(given) > 1:
        raise InputError(
            f"{' and '.join(given)} were both given, expected one of them: each says what the motion is for"
        )
    if discriminate is None and noise is not None:
        raise InputError("--noise was given without --discriminate, expected --discriminate A B too")
    if discriminate is None and cover is None and joint is not None:
        raise InputError("--joint was given alone, expected --discriminate A B or --cover EFFECT too")


def _designed(
    source: Robot | Estimate,
    criterion: str | None,
    discriminate: tuple[str, str] | None,
    cover: str | None,
    joint: int | None,
    noise: float | None,
    settings: dict[str, Any],
) -> Design | Discrimination | Coverage:
    """The design for what was asked."""
    if discriminate is not None:
        from physident.excitation.design_discriminating import design_discriminating

        return design_discriminating(source, *discriminate, joint, noise=noise, **settings)
    if cover is not None:
        from physident.estimation.estimate import Estimate
        from physident.excitation.design_covering import design_covering

        if not isinstance(source, Estimate):
            raise InputError(
                "--cover was given with --robot, expected --model: an identified model with a learned effect"
            )
        return design_covering(source, cover, joint, **settings)
    from physident.excitation.design_trajectory import design_trajectory

    return design_trajectory(source, criterion or "condition", **settings)


def _source(robot: Robot | None, model: Path | None) -> Robot | Estimate:
    from physident.estimation.estimate_file import load_estimate

    if model is not None:
        if robot is not None:
            raise InputError("--robot and --model were both given, expected one of them: a model contains its robot")
        return load_estimate(model)
    if robot is None:
        raise InputError("which arm? expected --robot (a description) or --model (an identified model)")
    return robot
