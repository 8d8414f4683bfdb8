"""physident inspect: the content of recordings, and the effects that they cannot show."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from physident.cli.app import app, busy, check_outputs, progress, read_recordings
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    JointsOption,
    LockOption,
    RateOption,
    Recordings,
    RobotOption,
    ToolOption,
    TopicOption,
    filter_of,
    layout_of,
    names_of,
    optional_robot,
    plot_option,
)
from physident.errors import InputError, warn

if TYPE_CHECKING:
    from physident.robots.robot import Robot

MAX_POSES = 2000  # of a recording, evenly spaced: enough to find singularities


@app.command(short_help="Check recordings before they are used.")
def inspect(
    recordings: Recordings,
    robot: RobotOption = None,
    joints: JointsOption = None,
    lock: LockOption = None,
    tool: ToolOption = None,
    effects: Annotated[
        str | None,
        typer.Option(
            "--effects",
            metavar="EFFECTS|all",
            help="Show which of these effects the recordings cannot show; all: of the catalogue.",
        ),
    ] = None,
    columns: ColumnsOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
    plot: Annotated[Path | None, plot_option("motion and effort")] = None,
) -> None:
    """Print the content of recordings: clock, ranges, bad rows, rest, agreement of channels, a suitable cutoff.

    With --robot, recordings are also held against the description: signs, order, gains, units, and what the efforts are."""
    from physident.recordings.inspection import inspect_recording

    if effects is not None and robot is None:
        raise InputError(
            "--effects needs a robot, expected --robot with a built-in name (ur5, ur10e), a .urdf, a MuJoCo .xml or a .toml"
        )
    check_outputs([*recordings, robot], plot=plot)
    arm = optional_robot(robot, joints, lock, tool)
    names = None if arm is None else arm.joint_names
    loaded = read_recordings(recordings, layout_of(columns, topic, rate), drive_gains, quiet=True, joints=names)
    inspections = [inspect_recording(recording) for recording in progress(loaded, "inspecting")]
    if plot is not None:
        from physident.graphics.figures.recordings import plot_recordings

        plot_recordings(loaded, plot)
    typer.echo("\n\n".join(map(repr, inspections)))
    if any(
        len(one.rest) != 1 or one.rest[0][1] - one.rest[0][0] < 0.95 * one.recording.duration for one in inspections
    ):
        typer.echo("\n" + _setup(arm, loaded))  # nothing can be said of a static pose
    if arm is not None:
        typer.echo("\n" + _manipulability(arm, loaded))
    if effects is not None and arm is not None:
        typer.echo("\n" + _visibility(arm, effects, loaded, cutoff))


def _setup(arm: Robot | None, recordings: list) -> str:
    """What is wrong with the set-up: of the recordings themselves, and together against a robot's description."""
    from physident.setup_checks.check_setup import check_setup

    if arm is None:
        found = [(recording, finding) for recording in recordings for finding in check_setup(None, recording)]
        rows = [f"  {Path(recording.source).name}: {finding}" for recording, finding in found]
        against = "the recordings themselves; --robot holds them against a description"
    else:
        findings = check_setup(arm, recordings)
        rows = [
            f"  {'' if finding.note else 'wrong: ' if finding.void else 'caution: '}{finding}" for finding in findings
        ]
        against = f"against the description of {arm.name}"
        if any(recording.effort_kind == "current" and recording.drive_gains is None for recording in recordings):
            against += ", sizes left out: the currents have no drive gains"
    return f"set-up, {against}:" + (" nothing wrong was seen" if not rows else "\n" + "\n".join(rows))


def _manipulability(arm: Robot, recordings: list) -> str:
    """The distance of the recorded poses from a singularity, with a warning where it is small."""
    from physident.identifiability.manipulability import measure_manipulability

    rows = []
    for recording in recordings:
        every = max(1, len(recording.q) // MAX_POSES)
        found = measure_manipulability(arm, recording.q[::every])
        rows.append(f"{Path(recording.source).name}: {found!r}")
        if found.warning:
            warn(f"{recording.source}: {found.warning}")
    return "\n".join(rows)


def _visibility(arm: Robot, effects: str, recordings: list, cutoff: float | None) -> str:
    from physident.dynamics.regressor import build_regressor
    from physident.effects.catalogue import make_effects
    from physident.estimation.identify import prepare_moving
    from physident.identifiability.visibility import measure_visibility

    filter = filter_of(cutoff)
    if effects.strip() == "all":
        from physident.identifiability.identifiability import measure_identifiability

        with busy("checking every effect"):
            return repr(measure_identifiability(arm, prepare_moving(arm, recordings, filter), filter))
    chosen = make_effects(names_of(effects))
    return repr(measure_visibility(build_regressor(arm, chosen, prepare_moving(arm, recordings, filter), filter)))
