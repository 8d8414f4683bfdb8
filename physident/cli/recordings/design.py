"""physident design: a robot or a model in, the motion that shows its parameters best out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from physident.cli.app import app, check_outputs
from physident.cli.options import JsonOption, RobotOption
from physident.errors import InputError, warn

if TYPE_CHECKING:
    from physident.estimation.estimate import Estimate
    from physident.robots.robot import Robot

MAX_RATE = 1e5  # Hz: no controller takes more


@app.command(short_help="The motion that shows a model's parameters best.")
def design(
    out: Annotated[Path, typer.Option("--out", help="The motion to write (physident.trajectory/1).")],
    robot: RobotOption = None,
    model: Annotated[Path | None, typer.Option("--model", help="A model file: all its effects are excited.")] = None,
    harmonics: Annotated[int, typer.Option("--harmonics", help="Harmonics of each joint's Fourier series.")] = 5,
    base_frequency: Annotated[
        float | None, typer.Option("--base-frequency", help="Base frequency [Hz]; 0.15, or 0.1 with --discriminate.")
    ] = None,
    periods: Annotated[
        int | None, typer.Option("--periods", help="How often the period is repeated; 1, or 2 with --discriminate.")
    ] = None,
    limits: Annotated[
        str,
        typer.Option("--limits", help="joint (position, speed, acceleration) or all (and torque, tool, table, links)."),
    ] = "all",
    criterion: Annotated[
        str | None, typer.Option("--criterion", help="condition (as it is without this), d_optimal or a_optimal.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="The same seed gives the same motion.")] = 0,
    table: Annotated[float, typer.Option("--table", help="Height of the table in the base frame [m].")] = 0.0,
    no_table: Annotated[bool, typer.Option("--no-table", help="There is no table.")] = False,
    clearance: Annotated[float, typer.Option("--clearance", help="Kept between links and to the table [m].")] = 0.02,
    meshes: Annotated[Path | None, typer.Option("--meshes", help="Folder of the URDF's mesh packages.")] = None,
    discriminate: Annotated[
        tuple[str, str] | None,
        typer.Option("--discriminate", metavar="A B", help="Tell two rival effects apart instead."),
    ] = None,
    joint: Annotated[int | None, typer.Option("--joint", help="Only on this joint, with --discriminate.")] = None,
    noise: Annotated[
        float | None, typer.Option("--noise", help="Torque noise after the filter [N m], with --discriminate.")
    ] = None,
    csv: Annotated[Path | None, typer.Option("--csv", help="Also write time, q, dq, ddq as a table.")] = None,
    rate: Annotated[float, typer.Option("--rate", help="Rows a second of that table [Hz].")] = 125.0,
    json_file: JsonOption = None,
    plot: Annotated[Path | None, typer.Option("--plot", help="Also draw the motion (.png, .pdf, .svg).")] = None,
) -> None:
    """Design a motion at rest at both ends, within the limits, along which all parameters show best."""
    from physident.excitation.design import design_trajectory
    from physident.excitation.discriminate import design_discriminating
    from physident.files import write_json

    if discriminate is not None and criterion is not None:
        raise InputError(
            "--criterion and --discriminate were both given, expected one: rivals have a criterion of their own"
        )
    if discriminate is None and (joint is not None or noise is not None):
        raise InputError("--joint and --noise belong to --discriminate A B, expected that too")

    check_outputs([robot, model], out, csv, json_file, plot=plot)
    if not 0 < rate <= MAX_RATE:
        raise InputError(f"--rate is {rate} Hz, expected a positive number up to {MAX_RATE:g}")
    source = _source(robot, model)
    with _progress("designing") as progress:
        settings = {
            "table": None if no_table else table,
            "clearance": clearance,
            "meshes": meshes,
            "progress": progress,
        }
        usual = (0.15, 1) if discriminate is None else (0.1, 2)
        frequency, repeated = (
            usual[0] if base_frequency is None else base_frequency,
            usual[1] if periods is None else periods,
        )
        shape = (limits, harmonics, frequency, repeated, seed)
        if discriminate is None:
            found = design_trajectory(source, criterion or "condition", *shape, **settings)  # pyright: ignore[reportArgumentType]
            plan = found
        else:
            found = design_discriminating(source, *discriminate, joint, *shape, noise, **settings)  # pyright: ignore[reportArgumentType]
            plan = found.design
    if csv is not None:
        plan.trajectory.write_csv(csv, rate)
    if plot is not None:
        from physident.view.figures.motion import plot_motion

        plot_motion(plan.trajectory, plot)
    if json_file is not None:
        write_json(json_file, found.as_dict())
    plan.trajectory.save(out)
    if plan.manipulability.warning:
        warn(plan.manipulability.warning)
    typer.echo(
        f"{found!r}\nwritten: {', '.join(str(path) for path in (out, csv, json_file, plot) if path is not None)}"
    )


def _source(robot: str | None, model: Path | None) -> Robot | Estimate:
    from physident.estimation.estimate_file import load_estimate
    from physident.robots.load import load_robot

    if model is not None:
        if robot is not None:
            raise InputError("--robot and --model were both given, expected one: a model brings its robot")
        return load_estimate(model)
    if robot is None:
        raise InputError("which arm? expected --robot (its description alone) or --model (a model file)")
    return load_robot(robot)


@contextmanager
def _progress(doing: str) -> Iterator[Callable[[float], None]]:
    """A progress bar on standard error, for the share that is done, once it has taken more than two seconds."""
    import time

    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    bar = Progress(console=console, transient=True, disable=not console.is_terminal)
    task, start = bar.add_task(doing, total=1.0), time.monotonic()

    def show(share: float) -> None:
        if not bar.live.is_started and time.monotonic() - start > 2:
            bar.start()
        bar.update(task, completed=share)

    try:
        yield show
    finally:
        if bar.live.is_started:
            bar.stop()
