"""physident report: a diagnosis as one HTML page."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from physident.cli.app import app, busy, check_outputs
from physident.errors import InputError


@app.command(short_help="Write a diagnosis as an HTML page.")
def report(
    diagnosis: Annotated[
        Path, typer.Option("--diagnosis", metavar="FILE", help="A diagnosis that diagnose --json wrote.")
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The page to write (.html).")],
) -> None:
    """Write a diagnosis as one HTML page that needs no network: the verdict in words, then its evidence."""
    from physident.report.page import write_report

    if out.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--out is {str(out)!r}, expected a file that ends in .html")
    check_outputs([diagnosis], out)
    words = ["physident", "report", "--diagnosis", str(diagnosis), "--out", str(out)]
    with busy("writing"):
        write_report(diagnosis, out, command=shlex.join(words))
    typer.echo(f"written: {out}")
