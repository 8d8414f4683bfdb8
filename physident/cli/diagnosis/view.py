"""physident view: recordings, models, a diagnosis and a designed motion in the rerun viewer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings
from physident.cli.options import ColumnsOption, CutoffOption, GainsOption, RobotOption
from physident.errors import InputError


@app.command(short_help="Look at it: arm, torques, residuals, effects.")
def view(
    recordings: Annotated[
        list[str] | None, typer.Argument(metavar="[REC]...", help="Recordings: .csv, .csv.gz, .npz, or patterns.")
    ] = None,
    model: Annotated[list[Path] | None, typer.Option("--model", help="A model file; repeat for several.")] = None,
    diagnosis: Annotated[
        Path | None, typer.Option("--diagnosis", help="A diagnosis (JSON): its models, findings, contacts.")
    ] = None,
    plan: Annotated[
        Path | None, typer.Option("--plan", help="A motion or a design (JSON), before it is recorded.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", help="Write the session to this file (.rrd).")] = None,
    web: Annotated[bool, typer.Option("--web", help="Serve the viewer to a browser on this machine.")] = False,
    robot: RobotOption = None,
    meshes: Annotated[Path | None, typer.Option("--meshes", help="Folder of the robot's meshes.")] = None,
    columns: ColumnsOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Show recordings, models, a diagnosis, a plan: in the viewer, or --out session.rrd; in a browser with --web."""
    from physident.diagnosis.result.saved import read_contents
    from physident.estimation.estimate_file import load_estimate
    from physident.robots.load import load_robot
    from physident.view.plan import plan_of
    from physident.view.session.content import compose
    from physident.view.session.session import check_session, show, write_session

    paths, files = recordings or [], model or []
    if not paths and plan is None:
        raise InputError("nothing to show; expected recordings, or --plan with a designed motion")
    if meshes is not None and not meshes.is_dir():
        raise InputError(f"--meshes {str(meshes)!r} is no folder; expected the one that package:// stands for")
    check_outputs([*paths, *files, diagnosis, plan, robot], out)
    if out is not None:
        check_session(out)
    models = dict(zip(_names(files), map(load_estimate, files), strict=True))
    said = read_contents(diagnosis) if diagnosis is not None else None
    stored = next((model.layout for model in models.values()), None if said is None else said.columns)
    layout = columns if columns is not None else stored
    loaded = read_recordings(paths, layout, drive_gains) if paths else []
    arm = load_robot(robot) if robot is not None else None
    content = replace(
        compose(models, loaded, said, arm, cutoff),
        plan=plan_of(plan) if plan is not None else None,
        meshes=meshes,
    )
    if out is not None:
        with busy("writing the session"):
            write_session(content, out)
        typer.echo(f"written: {out}" + ("" if web else f"; open it with: rerun {out}"))
    if out is None or web:
        show(content, out, web)


def _names(files: list[Path]) -> list[str]:
    """What models are called: the file's name without its ending, the whole path where two are alike."""
    stems = [file.stem for file in files]
    return [stem if stems.count(stem) == 1 else str(file) for stem, file in zip(stems, files, strict=True)]
