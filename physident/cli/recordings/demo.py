"""physident demo: from generated recordings to a diagnosis."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app, busy


@app.command(short_help="Diagnose an arm with a hidden change.")
def demo(
    folder: Annotated[
        Path, typer.Option("--folder", metavar="FOLDER", help="Folder for recordings and results.")
    ] = Path("demo"),
    seed: Annotated[
        int, typer.Option("--seed", min=0, metavar="N", help="Seed of the hidden change, motions and noise.")
    ] = 0,
) -> None:
    """Simulate a UR5 before and after a hidden change, diagnose it, and reveal the change."""
    from physident.demo.run import run_demo

    with busy("simulating an arm before and after a change, and diagnosing it"):
        demo = run_demo(folder, seed)
    typer.echo(repr(demo))
