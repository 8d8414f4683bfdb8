"""physident payload: mass, centre of mass and inertia of the load that an arm carries."""

from __future__ import annotations

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings, write_result
from physident.cli.options import ColumnsOption, CutoffOption, GainsOption, JsonOption, ModelOption, Recordings


@app.command(short_help="Identify the load that an arm carries.")
def payload(
    recordings: Recordings,
    model: ModelOption,
    json_out: JsonOption = None,
    columns: ColumnsOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Identify the load on the last link from recordings with it, and a model of the arm without it."""
    from physident.estimation.estimate_file import load_estimate
    from physident.estimation.payload.identify_payload import identify_payload

    check_outputs([*recordings, model], json_out)
    estimate = load_estimate(model).with_cutoff(cutoff)
    loaded = read_recordings(recordings, columns if columns is not None else estimate.layout, drive_gains)
    with busy("identifying"):
        found = identify_payload(estimate, loaded)
    write_result(json_out, "payload", found.as_dict())
    typer.echo(repr(found))
