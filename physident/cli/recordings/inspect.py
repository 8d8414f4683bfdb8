"""physident inspect: the content of recordings, and the effects that they cannot show."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from physident.cli.app import app, busy, check_outputs, progress, read_recordings, write_result
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    JointsOption,
    JsonOption,
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
    from physident.identifiability.identifiability import Identifiability
    from physident.identifiability.manipulability import Manipulability
    from physident.identifiability.visibility import Visibility
    from physident.recordings.recording import Recording
    from physident.robots.robot import Robot
    from physident.setup_checks.finding import SetupFinding

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
    json_out: JsonOption = None,
) -> None:
    """Print the content of recordings: clock, ranges, bad rows, rest, agreement of channels, a suitable cutoff.

    With --robot, recordings are also held against the description: signs, order, gains, units, and what the efforts are."""
    from physident.recordings.inspection import inspect_recording

    if effects is not None and robot is None:
        raise InputError(
            "--effects needs a robot, expected --robot with a built-in name (ur5, ur10e), a .urdf, a MuJoCo .xml or a .toml"
        )
    check_outputs([*recordings, robot], json_out, plot=plot)
    arm = optional_robot(robot, joints, lock, tool)
    names = None if arm is None else arm.joint_names
    loaded = read_recordings(recordings, layout_of(columns, topic, rate), drive_gains, quiet=True, joints=names)
    inspections = [inspect_recording(recording, arm) for recording in progress(loaded, "inspecting")]
    if plot is not None:
        from physident.graphics.figures.recordings import plot_recordings

        plot_recordings(loaded, plot)
    typer.echo("\n\n".join(map(repr, inspections)))
    result: dict[str, Any] = {"recordings": [one.as_dict() for one in inspections], "set_up": []}
    if any(
        len(one.rest) != 1 or one.rest[0][1] - one.rest[0][0] < 0.95 * one.recording.duration for one in inspections
    ):
        findings = _findings(arm, loaded)
        result["set_up"] = [{"path": path, **finding.as_dict()} for path, finding in findings]
        typer.echo("\n" + _setup(arm, loaded, findings))  # nothing can be said of a static pose
    if arm is not None:
        measured = _manipulability(arm, loaded)
        result["manipulability"] = [{"path": path, **found.as_dict()} for path, found in measured]
        typer.echo("\n" + "\n".join(f"{Path(path).name}: {found!r}" for path, found in measured))
    if effects is not None and arm is not None:
        seen = _visibility(arm, effects, loaded, cutoff)
        result["effects"] = seen.as_dict()
        typer.echo(f"\n{seen!r}")
    write_result(json_out, "inspection", result)


def _findings(arm: Robot | None, recordings: list[Recording]) -> list[tuple[str | None, SetupFinding]]:
    """What is wrong with the set-up: with the path, of each recording itself; together, against a robot's description."""
    from physident.setup_checks.check_setup import check_setup

    if arm is not None:
        found = check_setup(arm, recordings)  # first, because it refuses other numbers of joints
        return [*_refused(arm, recordings), *((None, finding) for finding in found)]
    return [(recording.source, finding) for recording in recordings for finding in check_setup(None, recording)]


def _refused(arm: Robot, recordings: list[Recording]) -> Iterator[tuple[str | None, SetupFinding]]:
    """Efforts that no model is fitted to, with the path of their recording."""
    from physident.recordings.checks import check_effort
    from physident.setup_checks.finding import SetupFinding

    for recording in recordings:
        if recording.effort_kind == "current" and recording.drive_gains is None:
            continue
        try:
            check_effort([recording], arm)
        except InputError as refusal:
            evidence = "identify and diagnose refuse it"
            yield (
                recording.source,
                SetupFinding(kind="effort_refused", joints=(), statement=str(refusal), evidence=evidence, void=True),
            )


def _setup(arm: Robot | None, recordings: list[Recording], findings: list[tuple[str | None, SetupFinding]]) -> str:
    """The findings of the set-up in words."""
    if arm is None:
        rows = [f"  {Path(path or '').name}: {finding}" for path, finding in findings]
        against = "the recordings themselves; --robot holds them against a description"
    else:
        rows = [
            f"  {'' if finding.note else 'wrong: ' if finding.void else 'caution: '}{finding}"
            for _, finding in findings
        ]
        against = f"against the description of {arm.name}"
        if any(recording.effort_kind == "current" and recording.drive_gains is None for recording in recordings):
            against += ", sizes left out: the currents have no drive gains"
    return f"set-up, {against}:" + (" nothing wrong was seen" if not rows else "\n" + "\n".join(rows))


def _manipulability(arm: Robot, recordings: list[Recording]) -> list[tuple[str, Manipulability]]:
    """The distance of each recording's poses from a singularity, with a warning where it is small."""
    from physident.identifiability.manipulability import measure_manipulability

    every_found = []
    for recording in recordings:
        every = max(1, len(recording.q) // MAX_POSES)
        found = measure_manipulability(arm, recording.q[::every])
        every_found.append((recording.source, found))
        if found.warning:
            warn(f"{recording.source}: {found.warning}")
    return every_found


def _visibility(
    arm: Robot, effects: str, recordings: list[Recording], cutoff: float | None
) -> Visibility | Identifiability:
    from physident.dynamics.regressor import build_regressor
    from physident.effects.catalogue import make_effects
    from physident.estimation.identify import prepare_moving
    from physident.identifiability.visibility import measure_visibility

    filter = filter_of(cutoff)
    if effects.strip() == "all":
        from physident.identifiability.identifiability import measure_identifiability

        with busy("checking every effect"):
            return measure_identifiability(arm, prepare_moving(arm, recordings, filter), filter)
    chosen = make_effects(names_of(effects))
    return measure_visibility(build_regressor(arm, chosen, prepare_moving(arm, recordings, filter), filter))
