"""physident diagnose: what recordings show that a model does not."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from physident.cli.app import app, check_outputs, read_recordings
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    JsonOption,
    Recordings,
    RobotOption,
    names_of,
)
from physident.errors import InputError

if TYPE_CHECKING:
    from physident.dynamics.model import Model
    from physident.estimation.estimate import Estimate
    from physident.recordings.recording import Recording


@app.command(short_help="What a model gets wrong.")
def diagnose(
    recordings: Recordings,
    model: Annotated[Path | None, typer.Option("--model", help="A model file that identify wrote.")] = None,
    robot: RobotOption = None,
    effects: Annotated[
        str | None,
        typer.Option(
            "--effects", help="With --robot: what the simulation has besides rigid_body, from the description."
        ),
    ] = None,
    holdout: Annotated[
        list[str] | None, typer.Option("--holdout", help="A recording to score at the end; repeat for several.")
    ] = None,
    json_out: JsonOption = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="The extended model to write (JSON), where something is found.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", help="Also draw the residual before and after (.png, .pdf, .svg).")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Draws the surrogates.")] = 0,
    recording_offsets: Annotated[
        bool,
        typer.Option("--recording-offsets", help="The torque sensors' zero may drift from recording to recording."),
    ] = False,
    columns: ColumnsOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Find what a model gets wrong. With --model, recordings it was fitted to say what is missing, new ones what is
    different. With --robot, nothing was identified: what a simulation from that description gets wrong. Recordings
    without motion are held against gravity and the friction that may hold the arm."""
    from physident.diagnosis.at_rest.at_rest import standing
    from physident.diagnosis.diagnose import diagnose as run
    from physident.recordings.signals import Filter

    if (model is None) == (robot is None):
        raise InputError("which model? expected one of --model (identified) and --robot (a description, as simulated)")
    if effects is not None and robot is None:
        raise InputError("--effects came beside --model, which has its own; expected --effects with --robot alone")
    held = holdout or []
    check_outputs([*recordings, *held, model, robot], json_out, out, plot=plot)
    start = _identified(model, cutoff) if model is not None else _described(str(robot), effects)
    nominal = model is None
    layout = columns if nominal or columns is not None else getattr(start, "layout", None)
    loaded = read_recordings(recordings, layout, drive_gains)
    unseen = read_recordings(held, layout, drive_gains) if held else []
    if standing(loaded):
        _still(start, loaded, json_out, [out, plot, *held, recording_offsets or None])
        return
    filter = Filter(cutoff) if nominal and cutoff is not None else None
    found = run(start, loaded, unseen, filter, seed, _say, layout if nominal else None, recording_offsets)
    if json_out is not None:
        found.save(json_out)
    if out is not None and found.estimate is not None:
        found.estimate.save(out)
    if plot is not None:
        from physident.view.figures.residual import plot_diagnosis

        named = any(finding.effect == "contact" for finding in found.findings)  # it lies in a diagnosed recording
        plot_diagnosis(found, loaded if named or not unseen else unseen, plot)
    typer.echo(repr(found))
    if out is not None:
        typer.echo(f"written: {out}" if found.estimate is not None else f"nothing found: {out} not written")


def _still(
    start: Estimate | Model,
    recordings: list[Recording],
    json_out: Path | None,
    of_motion: list[Path | str | bool | None],
) -> None:
    from physident.diagnosis.at_rest.at_rest import diagnose_at_rest

    if any(option is not None for option in of_motion):
        raise InputError(
            "no recording moves; expected a motion for --out, --plot, --holdout and --recording-offsets, or none of them"
        )
    found = diagnose_at_rest(start, recordings)
    if json_out is not None:
        found.save(json_out)
    typer.echo(repr(found))


def _identified(path: Path, cutoff: float | None) -> Estimate:
    from physident.estimation.estimate_file import load_estimate

    return load_estimate(path).with_cutoff(cutoff)


def _described(source: str, effects: str | None) -> Model:
    """What a simulation of a robot's description computes: rigid links, and the effects that it names besides."""
    from physident.dynamics.model import Model
    from physident.robots.load import load_robot

    named = names_of(effects or "")
    if effects is not None and not named:
        raise InputError(f"--effects is {effects!r}, expected names of effects, or no --effects for rigid_body alone")
    if repeated := [name for name in dict.fromkeys(named) if named.count(name) > 1]:
        raise InputError(f"--effects names {', '.join(repeated)} twice; expected each effect once")
    return Model.nominal(load_robot(source), ["rigid_body", *(name for name in named if name != "rigid_body")])


def _say(text: str) -> None:
    typer.echo(f"physident: trying {text}", err=True)
