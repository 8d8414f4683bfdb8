"""physident resume: what the recordings of a planned session have settled."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app, busy, check_outputs, read_recordings
from physident.cli.options import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    JsonOption,
    RateOption,
    TopicOption,
    filter_of,
    layout_of,
)
from physident.errors import InputError


@app.command(short_help="Say what a planned session has settled.")
def resume(
    session: Annotated[Path, typer.Argument(metavar="SESSION", help="The folder that physident plan wrote.")],
    recordings: Annotated[
        list[str],
        typer.Option(
            "--recordings",
            metavar="RECORDING...",
            help="Recordings of its pieces, up to the next option: named as the pieces are, or in their order.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="Write the identified model, with what was found (JSON)."),
    ] = None,
    json_out: JsonOption = None,
    seed: Annotated[int, typer.Option("--seed", min=0, metavar="N", help="Seed of the surrogates.")] = 0,
    columns: ColumnsOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Identify and diagnose with the recordings of a planned session and those from before it; say which questions are
    settled, which are not, and whether another session pays. --json writes the diagnosis, from which the next one is planned."""
    from dataclasses import replace

    from physident.diagnosis.next_session.resume import resume_session
    from physident.diagnosis.next_session.saved_session import match_recordings, read_session
    from physident.outputs import together
    from physident.recordings.load import find_recordings

    planned = read_session(session)
    before = planned.diagnosis
    if before is not None and cutoff is not None:
        raise InputError(f"--cutoff is {cutoff:g} Hz, expected none: the session keeps the cutoff of its diagnosis")
    files = find_recordings(recordings)
    named = match_recordings(planned, files)
    check_outputs([*files, session], out, json_out)
    layout = layout_of(columns, topic, rate, None if before is None else before.layout)
    loaded = read_recordings(list(named.values()), layout, drive_gains, joints=planned.model.robot.joint_names)
    by_leg = dict(zip(named, loaded, strict=True))
    with busy("resuming") as say:
        result = resume_session(planned, by_leg, None if cutoff is None else filter_of(cutoff), layout, seed, say)
    saved = str(out) if out is not None and result.diagnosis.estimate is not None else None
    model_file = before.model_file if before is not None else (str(out) if out is not None else None)
    found = replace(result.diagnosis, model_file=model_file, extended_file=saved)
    with together():
        if json_out is not None:
            found.save(json_out)
        if out is not None and result.estimate is not None:
            result.estimate.save(out)
    typer.echo(repr(replace(result, diagnosis=found)))
    if out is not None:
        typer.echo(f"written: {out}" if result.estimate is not None else f"no model was identified: {out} not written")
