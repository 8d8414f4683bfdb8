"""physident diagnose: find the effects that a model lacks or has wrong."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    GearRatiosOption,
    JointsOption,
    JsonOption,
    LockOption,
    RateOption,
    Recordings,
    RobotOption,
    ToolOption,
    TopicOption,
    layout_of,
    names_of,
    optional_robot,
    plot_option,
    robot_of,
)
from physident.errors import InputError, warn

if TYPE_CHECKING:
    from physident.diagnosis.result.diagnosis import Diagnosis
    from physident.dynamics.model import Model
    from physident.estimation.estimate import Estimate
    from physident.recordings.recording import Recording
    from physident.robots.robot import Robot

FAULT_FOUND = 4  # exit code of --fail-on


@app.command(short_help="Find what a model gets wrong, and why.")
def diagnose(
    recordings: Recordings,
    model: Annotated[Path | None, typer.Option("--model", metavar="FILE", help="A model that identify wrote.")] = None,
    robot: RobotOption = None,
    joints: JointsOption = None,
    lock: LockOption = None,
    tool: ToolOption = None,
    gear_ratios: GearRatiosOption = None,
    effects: Annotated[
        str | None,
        typer.Option(
            "--effects",
            metavar="EFFECTS",
            help="With --robot: effects of the simulation besides rigid_body, separated by commas; default: those of a MuJoCo file.",
        ),
    ] = None,
    holdout: Annotated[
        list[str] | None,
        typer.Option(
            "--holdout", metavar="RECORDING...", help="Recordings to validate the result on, up to the next option."
        ),
    ] = None,
    before: Annotated[
        list[str] | None,
        typer.Option(
            "--before",
            metavar="RECORDING...",
            help="With --model: recordings from before a change, up to the next option; default: those of the model.",
        ),
    ] = None,
    fail_on: Annotated[
        str | None,
        typer.Option(
            "--fail-on",
            metavar="cause|unexplained",
            help="End with exit code 4 where a cause is found, or also where the error has structure that nothing explains.",
        ),
    ] = None,
    json_out: JsonOption = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="Write the extended model (JSON), if something is found."),
    ] = None,
    plot: Annotated[Path | None, plot_option("the residual before and after")] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, metavar="N", help="Seed of the surrogates.")] = 0,
    recording_offsets: Annotated[
        bool,
        typer.Option("--recording-offsets", help="Allow the torque sensors' zero to drift between recordings."),
    ] = False,
    simulator: Annotated[
        str | None,
        typer.Option(
            "--simulator", metavar="NAME", help="Also simulate both models half a second ahead: mujoco or physident."
        ),
    ] = None,
    columns: ColumnsOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
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

    if robot is None:
        optional_robot(robot, joints, lock, tool, gear_ratios)
    if (model is None) == (robot is None):
        raise InputError("which model? expected either --model (an identified model) or --robot (a description)")
    if effects is not None and robot is None:
        raise InputError(
            "--effects and --model were both given, expected --effects with --robot only: a model has its effects"
        )
    if simulator not in (None, "mujoco", "physident"):
        raise InputError(f"--simulator is {simulator!r}, expected mujoco or physident")
    if before is not None and model is None:
        raise InputError(
            "--before was given without --model; expected it with a model that was identified before a change"
        )
    if fail_on not in (None, "cause", "unexplained"):
        raise InputError(f"--fail-on is {fail_on!r}, expected cause or unexplained")
    holdouts = holdout or []
    check_outputs([*recordings, *holdouts, *(before or []), model, robot], json_out, out, plot=plot)
    start = (
        _identified(model, cutoff)
        if model is not None
        else _described(robot_of(robot, joints, lock, tool, gear_ratios), effects)
    )
    nominal = model is None
    layout = layout_of(columns, topic, rate, start.layout if isinstance(start, Estimate) else None)
    named = (start.model if isinstance(start, Estimate) else start).robot.joint_names
    loaded = read_recordings(recordings, layout, drive_gains, joints=named)
    unseen = read_recordings(holdouts, layout, drive_gains, joints=named) if holdouts else []
    control = read_recordings(before, layout, drive_gains, joints=named) if before else None
    if fail_on is not None:
        _refuse_wrong_setup(start, loaded, unseen)
    filter = Filter(cutoff) if nominal and cutoff is not None else None
    with busy("searching") as say:
        found = run(start, loaded, unseen, filter, seed, say, layout if nominal else None, recording_offsets, control)
    needs_motion = {"--out": out, "--plot": plot, "--fail-on": fail_on}
    if isinstance(found, AtRest) and (options := [name for name, given in needs_motion.items() if given is not None]):
        raise InputError(f"no recording moves; expected recordings in motion for {' and '.join(options)}")
    if simulator is not None and not isinstance(found, AtRest):
        from physident.replay.gain import with_simulator

        try:
            found = with_simulator(found, loaded, unseen, simulator)  # pyright: ignore[reportArgumentType]
        except InputError as error:  # the diagnosis stands without it
            warn(f"not simulated: {error}")
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
        beyond = any(not finding.handed_on for finding in found.findings)
        why = "the unseen recordings are predicted worse by it" if beyond else "nothing to extend the model by"
        kept = ", and what it holds is older" if out.exists() else ""
        typer.echo(f"written: {out}" if found.estimate is not None else f"{why}: {out} not written{kept}")
    if fail_on is not None and isinstance(found, Diagnosis):
        _refuse_no_answer(found)
        if _fails(found, fail_on):
            raise typer.Exit(FAULT_FOUND)


def _fails(found: Diagnosis, fail_on: str) -> bool:
    return bool(found.causes) or (fail_on == "unexplained" and found.verdict == "unexplained")


def _refuse_no_answer(found: Diagnosis) -> None:
    """Raises InputError where nobody can say whether something has changed: a job would take silence for health."""
    from physident.diagnosis.grading.holdout import OLD_HOLDOUT
    from physident.diagnosis.remainder.standing_still import FROZEN

    if found.controlled is False:
        raise InputError(
            "the recordings that the model was fitted to are not at hand, so a cause may have been there before; expected them with --fail-on: where"
            " they were, or as --before"
        )
    for text in found.warnings:
        if text.startswith((OLD_HOLDOUT, FROZEN)):
            raise InputError(text)


def _refuse_wrong_setup(start: Estimate | Model, *groups: list[Recording]) -> None:
    """Raises InputError for a set-up that voids the answer: a job has nobody who reads the warning."""
    from physident.estimation.estimate import Estimate
    from physident.setup_checks.check_setup import check_setup_of_each

    model, gains = (start.model, start.drive_gains) if isinstance(start, Estimate) else (start, None)
    with warnings.catch_warnings():  # the diagnosis repeats them
        warnings.simplefilter("ignore")
        used = [[recording.with_default_drive_gains(gains) for recording in group] for group in groups]
    for finding in check_setup_of_each(model.robot, *used):
        if finding.void:
            raise InputError(f"{finding}; expected a right set-up with --fail-on")


def _identified(path: Path, cutoff: float | None) -> Estimate:
    from physident.estimation.estimate_file import load_estimate

    return load_estimate(path).with_cutoff(cutoff)


def _described(robot: Robot, effects: str | None) -> Model:
    """The model of a simulation of a robot's description: rigid links, and the effects of --effects, or else those that a
    simulator's own file states."""
    from physident.dynamics.model import Model

    if effects is None:
        return Model.described(robot)
    named = names_of(effects)
    if not named:
        raise InputError(f"--effects is {effects!r}, expected names of effects, or no --effects for rigid_body alone")
    if repeated := [name for name in dict.fromkeys(named) if named.count(name) > 1]:
        raise InputError(f"--effects names {', '.join(repeated)} twice; expected each effect once")
    return Model.nominal(robot, ["rigid_body", *(name for name in named if name != "rigid_body")])
