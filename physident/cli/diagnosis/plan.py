"""physident plan: the session to record next, from a diagnosis or for a new arm."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from shlex import quote
from typing import Annotated, Any

import typer

from physident.cli.app import app, busy, check_outputs, share_done
from physident.cli.options import (
    JointsOption,
    JsonOption,
    LockOption,
    MeshesOption,
    RobotOption,
    ToolOption,
    optional_robot,
)
from physident.errors import InputError

MAX_RATE = 1e4  # Hz, faster than any controller takes set points


@app.command(short_help="Plan the session to record next.")
def plan(
    out: Annotated[Path, typer.Option("--out", metavar="FOLDER", help="The folder to write the session into.")],
    diagnosis: Annotated[
        Path | None,
        typer.Option("--diagnosis", metavar="FILE", help="A diagnosis (JSON), whose open questions are asked."),
    ] = None,
    robot: RobotOption = None,
    joints: JointsOption = None,
    lock: LockOption = None,
    tool: ToolOption = None,
    repeat: Annotated[
        list[Path] | None,
        typer.Option(
            "--repeat",
            metavar="FILE",
            help="With --robot: a recording whose motion is recorded again, to be compared row by row; may be repeated.",
        ),
    ] = None,
    minutes: Annotated[
        float,
        typer.Option("--minutes", metavar="MIN", help="Time in motion [min], all pieces together, to within a piece."),
    ] = 3.0,
    load: Annotated[
        float | None,
        typer.Option(
            "--load", metavar="KG", help="A load that was weighed [kg]; some pieces then carry it at the tool."
        ),
    ] = None,
    limits: Annotated[
        str,
        typer.Option(
            "--limits",
            metavar="joint|all",
            help="joint: position, speed, acceleration; all: also torque, tool speed, table and self-collision.",
        ),
    ] = "all",
    robot_limits: Annotated[
        str | None,
        typer.Option(
            "--robot-limits",
            metavar="LIMITS",
            help='Tighter limits than the description\'s: "speed=1.0 acceleration=2,2,2,4,4,4 torque=40 lower=-2 upper=2".',
        ),
    ] = None,
    table: Annotated[
        float, typer.Option("--table", metavar="M", help="Height of the table in the base frame [m].")
    ] = 0.0,
    no_table: Annotated[bool, typer.Option("--no-table", help="Plan without a table.")] = False,
    clearance: Annotated[
        float, typer.Option("--clearance", metavar="M", help="Distance between links and to the table [m].")
    ] = 0.02,
    meshes: MeshesOption = None,
    noise: Annotated[
        float | None,
        typer.Option("--noise", metavar="NM", help="With --robot: RMS of the torque noise after the filter [N m]."),
    ] = None,
    pool: Annotated[int, typer.Option("--pool", metavar="N", help="Number of motions to choose from.")] = 18,
    rate: Annotated[float, typer.Option("--rate", metavar="HZ", help="Rate of tables and programs [Hz].")] = 125.0,
    seed: Annotated[int, typer.Option("--seed", min=0, metavar="N", help="The same seed gives the same session.")] = 0,
    json_out: JsonOption = None,
) -> None:
    """Plan the session to record next: motions within every limit that, in some minutes, settle most of what a diagnosis left
    open (--diagnosis), or show most of a new arm (--robot)."""
    from physident.diagnosis.next_session.plan import plan_next
    from physident.diagnosis.result.saved import read_diagnosis
    from physident.dynamics.model import Model
    from physident.excitation.design_trajectory import Settings
    from physident.excitation.limits.robot_limits import with_limits
    from physident.excitation.motion.sequence import MotionSequence
    from physident.excitation.recording_session import design_session
    from physident.excitation.session.plan import Budget
    from physident.files import write_json
    from physident.graphics.plan import Plan
    from physident.graphics.session.content import SessionContent
    from physident.graphics.session.write import write_session
    from physident.outputs import together

    arm = optional_robot(robot, joints, lock, tool)
    if (arm is None) == (diagnosis is None):
        raise InputError("which arm? expected either --diagnosis (what is open) or --robot (a first session)")
    if noise is not None and diagnosis is not None:
        raise InputError(
            "--noise and --diagnosis were both given, expected --noise with --robot only: a diagnosis has its noise"
        )
    if repeat and diagnosis is not None:
        raise InputError(
            "--repeat and --diagnosis were both given, expected --repeat with --robot only: a diagnosis of a change knows the"
            " recordings of its model"
        )
    if not 0 < rate <= MAX_RATE:
        raise InputError(f"--rate is {rate} Hz, expected a positive number up to {MAX_RATE:g}")
    height = None if no_table else table
    checked: dict[str, Any] = {
        "limits": limits,
        "seed": seed,
        "table": height,
        "clearance": clearance,
        "meshes": meshes,
    }
    Settings(harmonics=5, base_frequency=0.1, periods=1, starts=1, generations=1, **checked)
    _check_folder(out)
    settings: dict[str, Any] = {
        "minutes": minutes, "load": load, "limits": limits, "table": height, "clearance": clearance, "meshes": meshes,
        "seed": seed, "pool": pool,
    }  # fmt: skip
    budget = Budget(**settings)
    found = read_diagnosis(diagnosis) if diagnosis is not None else None
    with share_done("planning") as progress:
        if found is not None:
            model = found.model.robot if robot_limits is None else with_limits(found.model.robot, robot_limits)
            extended = None if found.extended is None else replace(found.extended, robot=model)
            limited = replace(found, model=replace(found.model, robot=model), extended=extended)
            shown, session = model, plan_next(limited, budget, progress)
        else:
            assert arm is not None
            shown = arm if robot_limits is None else with_limits(arm, robot_limits)
            session = design_session(shown, noise=noise, repeat=repeat or (), progress=progress, **settings)
    folder = _made(out)
    preview = folder / "preview.rrd"
    record: dict[str, Any] = {
        "settings": {**settings, "meshes": None if meshes is None else str(meshes)},
        "model": Model.nominal(shown).as_dict(),
        "diagnosis": None if found is None else "diagnosis.json",
    }
    copy = folder / "diagnosis.json"
    own = [] if found is None or (copy.exists() and diagnosis is not None and copy.samefile(diagnosis)) else [copy]
    check_outputs([diagnosis, robot], *session.paths(folder), *own, preview, json_out)
    with together():
        session.write(folder, shown, rate, record)
        if found is not None and own:
            write_json(copy, found.as_dict())
        if json_out is not None:
            write_json(json_out, session.as_dict())
        content = SessionContent(
            shown, plan=Plan(MotionSequence(tuple(leg.trajectory for leg in session.legs))), meshes=meshes
        )
        with busy("writing the preview"):
            write_session(content, preview)
    typer.echo(
        f"{session!r}\nwritten: {folder}: {len(session.legs)} motions (.json, .csv, .script, .yaml), session.json; look at it with: rerun {quote(str(preview))}"
    )


def _check_folder(folder: Path) -> None:
    """Raises InputError, before any work, where a folder cannot be made."""
    existing = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    if not existing.is_dir() or not os.access(existing, os.W_OK):
        raise InputError(f"--out {str(folder)!r} cannot be made in {str(existing)!r}; expected a folder to write into")


def _made(folder: Path) -> Path:
    """The folder, made where it does not exist; raises InputError where that cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--out {str(folder)!r}: {error.strerror or error}; expected a folder to write into") from None
    return folder
