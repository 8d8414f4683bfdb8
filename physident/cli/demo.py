"""physident demo: the whole way on generated recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app


@app.command(short_help="The whole way on generated recordings.")
def demo(
    folder: Annotated[Path, typer.Option("--folder", help="Where to write recordings, model and figure.")] = Path(
        "demo"
    ),
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the motions and the noise.")] = 0,
) -> None:
    """Identify a generated UR5 on one recording and judge the model on another."""
    from physident.demo import run_demo

    typer.echo(repr(run_demo(folder, seed)))
