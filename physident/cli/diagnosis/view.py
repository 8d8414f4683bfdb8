"""physident view: recordings, models, a diagnosis and a planned motion in the rerun viewer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from shlex import quote
from typing import Annotated

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    JointsOption,
    LockOption,
    MeshesOption,
    RateOption,
    RobotOption,
    ToolOption,
    TopicOption,
    layout_of,
    optional_robot,
)
from physident.errors import InputError


@app.command(short_help="Show arm, torques, residuals and effects in rerun.")
def view(
    recordings: Annotated[
        list[str] | None,
        typer.Argument(metavar="[RECORDING]...", help="Recordings, as for identify, or patterns such as runs/*.csv."),
    ] = None,
    model: Annotated[
        list[Path] | None, typer.Option("--model", metavar="FILE...", help="Models, up to the next option.")
    ] = None,
    diagnosis: Annotated[
        Path | None, typer.Option("--diagnosis", metavar="FILE", help="A diagnosis (JSON), with its models.")
    ] = None,
    plan: Annotated[
        Path | None, typer.Option("--plan", metavar="FILE", help="A planned motion: a trajectory or a design (JSON).")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Write the session to this file (.rrd).")
    ] = None,
    web: Annotated[bool, typer.Option("--web", help="Show the session in a browser on this machine.")] = False,
    robot: RobotOption = None,
    joints: JointsOption = None,
    lock: LockOption = None,
    tool: ToolOption = None,
    meshes: MeshesOption = None,
    columns: ColumnsOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Show recordings, models, a diagnosis and a planned motion: in the viewer, in a browser (--web), or as a file (--out)."""
    from physident.diagnosis.result.saved import read_diagnosis
    from physident.estimation.estimate_file import load_estimate
    from physident.graphics.plan import plan_of
    from physident.graphics.session.content import compose
    from physident.graphics.session.write import check_session_path, write_session
    from physident.graphics.view import show

    paths, files = recordings or [], model or []
    if not paths and plan is None:
        raise InputError("nothing to show; expected recordings, or a planned motion (--plan)")
    check_outputs([*paths, *files, diagnosis, plan, robot], out)
    if out is not None:
        check_session_path(out)
    models = dict(zip(_names(files), map(load_estimate, files), strict=True))
    contents = read_diagnosis(diagnosis) if diagnosis is not None else None
    source = next(iter(models.values()), contents)
    layout = layout_of(columns, topic, rate, None if source is None else source.layout)
    arm = optional_robot(robot, joints, lock, tool)
    known = arm if arm is not None or source is None else source.model.robot
    names = None if known is None else known.joint_names
    loaded = read_recordings(paths, layout, drive_gains, joints=names) if paths else []
    content = replace(
        compose(models, loaded, contents, arm, cutoff),
        plan=plan_of(plan) if plan is not None else None,
        meshes=meshes,
    )
    if out is not None:
        with busy("writing the session"):
            write_session(content, out)
        typer.echo(f"written: {out}" + ("" if web else f"; open it with: rerun {quote(str(out))}"))
    if out is None or web:
        show(content, out, web)


def _names(files: list[Path]) -> list[str]:
    """Names of models: the file's name without its ending, or the path where two files have the same name."""
    stems = [file.stem for file in files]
    return [stem if stems.count(stem) == 1 else str(file) for stem, file in zip(stems, files, strict=True)]
