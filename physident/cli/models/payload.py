"""physident payload: mass, centre of mass and inertia of the load that an arm carries."""

from __future__ import annotations

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings, write_result
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    JsonOption,
    ModelOption,
    RateOption,
    Recordings,
    TopicOption,
    layout_of,
)


@app.command(short_help="Identify the load that an arm carries.")
def payload(
    recordings: Recordings,
    model: ModelOption,
    json_out: JsonOption = None,
    columns: ColumnsOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Identify the load on the last link from recordings with it, and a model of the arm without it."""
    from physident.estimation.estimate_file import load_estimate
    from physident.estimation.payload.identify_payload import identify_payload

    check_outputs([*recordings, model], json_out)
    estimate = load_estimate(model).with_cutoff(cutoff)
    layout = layout_of(columns, topic, rate, estimate.layout)
    loaded = read_recordings(recordings, layout, drive_gains, joints=estimate.model.robot.joint_names)
    with busy("identifying"):
        found = identify_payload(estimate, loaded)
    write_result(json_out, "payload", found.as_dict())
    typer.echo(repr(found))
