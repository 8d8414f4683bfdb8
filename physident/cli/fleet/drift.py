"""physident drift: which arms of a fleet change, since when, and why."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app, busy, check_outputs, write_result
from physident.cli.options import JsonOption
from physident.errors import InputError


@app.command(short_help="Find the arms of a fleet that change.")
def drift(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="The folder that fleet --out wrote.")],
    false_alarms: Annotated[
        float, typer.Option("--false-alarms", metavar="RATE", help="False alarms allowed for each arm and year.")
    ] = 0.01,
    page: Annotated[Path | None, typer.Option("--page", metavar="FILE", help="Also write an HTML page.")] = None,
    session: Annotated[
        Path | None, typer.Option("--session", metavar="FILE", help="Also write a session for the rerun viewer (.rrd).")
    ] = None,
    until: Annotated[
        datetime | None,
        typer.Option("--until", metavar="DATE", formats=["%Y-%m-%d"], help="Leave out recordings of later days."),
    ] = None,
    json_out: JsonOption = None,
) -> None:
    """Print the arms that need attention, each with the cause that explains its change best."""
    from physident.fleet.drift.alarms import find_drift
    from physident.fleet.drift.record import drift_as_dict
    from physident.outputs import together

    if page is not None and page.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--page is {str(page)!r}, expected a file that ends in .html")
    if session is not None and session.suffix.lower() != ".rrd":
        raise InputError(f"--session is {str(session)!r}, expected a file that ends in .rrd")
    check_outputs([], page, json_out, session)
    with busy("searching for changes"):
        found = find_drift(folder, false_alarms, None if until is None else until.date())
    with together():
        write_result(json_out, "drift", drift_as_dict(found))
        if page is not None:
            from physident.fleet.drift.page import write_page

            write_page(found, page)
        if session is not None:
            from physident.fleet.drift.session import write_drift_session

            write_drift_session(found, session)
    typer.echo(repr(found))
