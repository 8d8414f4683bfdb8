"""physident diagnose: what recordings show that a model does not."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import (
    ColumnsOption,
    CutoffOption,
    GainsOption,
    JsonOption,
    ModelOption,
    Recordings,
    app,
    check_outputs,
    read_recordings,
)


@app.command(short_help="What a model gets wrong.")
def diagnose(
    recordings: Recordings,
    model: ModelOption,
    holdout: Annotated[
        list[str] | None, typer.Option("--holdout", help="A recording to score at the end; repeat for several.")
    ] = None,
    json_out: JsonOption = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="The extended model to write (JSON), where something is found.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", help="Also draw the residual before and after (.png, .pdf, .svg).")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Draws the surrogates.")] = 0,
    columns: ColumnsOption = None,
    drive_gains: GainsOption = None,
    cutoff: CutoffOption = None,
) -> None:
    """Find what a model gets wrong: recordings it was fitted to say what is missing, new ones what is different."""
    from physident.diagnosis.diagnose import diagnose as run
    from physident.estimation.estimate import load_estimate
    from physident.validation import with_cutoff

    held = holdout or []
    check_outputs([*recordings, *held, model], json_out, out, plot=plot)
    estimate = with_cutoff(load_estimate(model), cutoff)
    layout = columns if columns is not None else estimate.columns
    loaded = read_recordings(recordings, layout, drive_gains)
    unseen = read_recordings(held, layout, drive_gains) if held else []
    found = run(estimate, loaded, unseen, seed=seed, progress=_say)
    if json_out is not None:
        found.save(json_out)
    if out is not None and found.estimate is not None:
        found.estimate.save(out)
    if plot is not None:
        from physident.view.plots_residual import plot_diagnosis

        named = any(finding.effect == "contact" for finding in found.findings)  # it lies in a diagnosed recording
        plot_diagnosis(found, loaded if named or not unseen else unseen, plot)
    typer.echo(repr(found))
    if out is not None:
        typer.echo(f"written: {out}" if found.estimate is not None else f"nothing found: {out} not written")


def _say(text: str) -> None:
    typer.echo(f"physident: found {text}", err=True)
