"""physident demo: the whole way on generated recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app, busy


@app.command(short_help="The whole way on generated recordings.")
def demo(
    folder: Annotated[Path, typer.Option("--folder", help="Where to write recordings and results.")] = Path("demo"),
    seed: Annotated[int, typer.Option("--seed", min=0, help="Draws what is hidden, motions and noise.")] = 0,
) -> None:
    """Diagnose a generated UR5 in which one effect was hidden, then reveal the truth."""
    from physident.demo.run import run_demo

    with busy("recording a generated arm before and after a change, and diagnosing it"):
        demo = run_demo(folder, seed)
    typer.echo(repr(demo))
