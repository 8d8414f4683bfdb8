"""physident diagnose: find the effects that a model lacks or has wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings
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


@app.command(short_help="Find what a model gets wrong, and why.")
def diagnose(
    recordings: Recordings,
    model: Annotated[Path | None, typer.Option("--model", metavar="FILE", help="A model that identify wrote.")] = None,
    robot: RobotOption = None,
    effects: Annotated[
        str | None,
        typer.Option(
            "--effects",
            metavar="EFFECTS",
            help="With --robot: effects of the simulation besides rigid_body, separated by commas.",
        ),
    ] = None,
    holdout: Annotated[
        list[str] | None,
        typer.Option(
            "--holdout", metavar="RECORDING...", help="Recordings to validate the result on, up to the next option."
        ),
    ] = None,
    json_out: JsonOption = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="Write the extended model (JSON), if something is found."),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="FIGURE", help="Also draw the residual before and after (.png, .pdf, .svg)."),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, metavar="N", help="Seed of the surrogates.")] = 0,
    recording_offsets: Annotated[
        bool,
        typer.Option("--recording-offsets", help="Allow the torque sensors' zero to drift between recordings."),
    ] = False,
    columns: ColumnsOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Find what a model gets wrong, and why.

    With --model and the recordings that it was fitted to, the diagnosis finds effects that the model lacks; with new
    recordings it finds what has changed. With --robot, it finds what a simulation of that description gets wrong. For
    recordings at standstill it reports whether static friction alone can explain the difference between measured and
    modelled gravity torque."""
    from physident.diagnosis.at_rest.poses import AtRest
    from physident.diagnosis.diagnose import diagnose as run
    from physident.diagnosis.result.diagnosis import Diagnosis
    from physident.estimation.estimate import Estimate
    from physident.outputs import together
    from physident.recordings.signals import Filter

    if (model is None) == (robot is None):
        raise InputError("which model? expected either --model (an identified model) or --robot (a description)")
    if effects is not None and robot is None:
        raise InputError(
            "--effects and --model were both given, expected --effects with --robot only: a model has its effects"
        )
    holdouts = holdout or []
    check_outputs([*recordings, *holdouts, model, robot], json_out, out, plot=plot)
    start = _identified(model, cutoff) if model is not None else _described(str(robot), effects)
    nominal = model is None
    layout = start.layout if columns is None and isinstance(start, Estimate) else columns
    loaded = read_recordings(recordings, layout, drive_gains)
    unseen = read_recordings(holdouts, layout, drive_gains) if holdouts else []
    filter = Filter(cutoff) if nominal and cutoff is not None else None
    with busy("searching") as say:
        found = run(start, loaded, unseen, filter, seed, say, layout if nominal else None, recording_offsets)
    if isinstance(found, AtRest) and (out is not None or plot is not None):
        raise InputError("no recording moves; expected recordings in motion for --out and --plot")
    if isinstance(found, Diagnosis):  # so that advice can be typed as it is printed
        saved = str(out) if out is not None and found.estimate is not None else None
        found = replace(found, model_file=str(model or robot), extended_file=saved)
    with together():
        if json_out is not None:
            found.save(json_out)
        if isinstance(found, Diagnosis) and out is not None and found.estimate is not None:
            found.estimate.save(out)
        if isinstance(found, Diagnosis) and plot is not None:
            from physident.graphics.figures.residual import plot_diagnosis

            contact = any(finding.effect == "contact" for finding in found.findings)  # it is in a diagnosed recording
            plot_diagnosis(found, loaded if contact or not unseen else unseen, plot)
    typer.echo(repr(found))
    if isinstance(found, Diagnosis) and out is not None:
        typer.echo(f"written: {out}" if found.estimate is not None else f"nothing found: {out} not written")


def _identified(path: Path, cutoff: float | None) -> Estimate:
    from physident.estimation.estimate_file import load_estimate

    return load_estimate(path).with_cutoff(cutoff)


def _described(source: str, effects: str | None) -> Model:
    """The model of a simulation of a robot's description: rigid links, and the effects of --effects."""
    from physident.dynamics.model import Model
    from physident.robots.load import load_robot

    named = names_of(effects or "")
    if effects is not None and not named:
        raise InputError(f"--effects is {effects!r}, expected names of effects, or no --effects for rigid_body alone")
    if repeated := [name for name in dict.fromkeys(named) if named.count(name) > 1]:
        raise InputError(f"--effects names {', '.join(repeated)} twice; expected each effect once")
    return Model.nominal(load_robot(source), ["rigid_body", *(name for name in named if name != "rigid_body")])
