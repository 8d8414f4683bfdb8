"""physident replay: how far a simulated arm is from the recorded one, before and after a diagnosis."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import Annotated

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    IncludeFittedOption,
    JsonOption,
    MeshesOption,
    RateOption,
    Recordings,
    TopicOption,
    layout_of,
    plot_option,
)
from physident.errors import InputError


@app.command(short_help="Simulate recordings, and measure how far the arm is off.")
def replay(
    recordings: Recordings,
    model: Annotated[
        list[Path], typer.Option("--model", metavar="FILE", help="A model; twice for the model before, and after.")
    ],
    simulator: Annotated[
        str, typer.Option("--simulator", metavar="NAME", help="mujoco, or physident for its own simulator.")
    ] = "mujoco",
    horizon: Annotated[
        float, typer.Option("--horizon", metavar="S", help="How long the arm is simulated from each state [s].")
    ] = 0.5,
    json_out: JsonOption = None,
    plot: Annotated[Path | None, plot_option("the errors")] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", metavar="FILE", help="Also write a session with the measured and the simulated arms (.rrd)."
        ),
    ] = None,
    meshes: MeshesOption = None,
    include_fitted: IncludeFittedOption = False,
    columns: ColumnsOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Simulate recordings with one model or two, and print how far the simulated arm is from the recorded one.

    From every measured state the arm is simulated over the horizon under the measured torque; and along the recorded
    motion, held by a controller."""
    from physident.estimation.estimate_file import load_estimate
    from physident.files import write_json
    from physident.graphics.session.write import check_session_path
    from physident.outputs import together
    from physident.replay.replay import replay as run
    from physident.validation.scores import refuse_fitted

    if len(model) > 2:
        raise InputError(f"{len(model)} models given, expected one or two: --model before.json --model after.json")
    check_outputs([*recordings, *model], json_out, out, plot=plot)
    if out is not None:
        check_session_path(out)
    models = [load_estimate(path).with_cutoff(cutoff) for path in model]
    layout = layout_of(columns, topic, rate, models[0].layout)
    loaded = read_recordings(recordings, layout, drive_gains, joints=models[0].model.robot.joint_names)
    if not include_fitted:
        for one in models:
            refuse_fitted(one, loaded)
    with busy("simulating"):
        replayed = run(models[0], models[1] if len(models) > 1 else None, loaded, simulator, horizon)  # pyright: ignore[reportArgumentType]
    with together():
        if json_out is not None:
            write_json(json_out, replayed.replay.as_dict())
        if plot is not None:
            from physident.replay.plot import plot_replay

            plot_replay(replayed, models[0].model.robot, plot)
        if out is not None:
            from physident.replay.session import write_replay

            write_replay(replayed, models[0].model.robot, out, meshes)
    typer.echo(repr(replayed.replay))
    if out is not None:
        typer.echo(f"written: {out}; open it with: rerun {quote(str(out))}")
