"""The page: one HTML file that needs no other file, assembled from its sections."""

from __future__ import annotations

from datetime import date
from pathlib import Path

from markupsafe import Markup

from physident.diagnosis.result.diagnosis import Diagnosis
from physident.diagnosis.result.saved import read_diagnosis
from physident.files import VERSION, write_text
from physident.outputs import check_target
from physident.report.markup import tag
from physident.report.reread import reread
from physident.report.sections.advice import advice
from physident.report.sections.answer import answer
from physident.report.sections.causes import causes, lacked_before
from physident.report.sections.evidence import evidence
from physident.report.sections.joint_errors import joint_errors
from physident.report.sections.provenance import provenance
from physident.report.sections.torques import torques
from physident.report.sections.unseen import unseen
from physident.report.stylesheet import STYLE

POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'"  # the browser loads and runs nothing, whatever the page contains
)


def write_report(diagnosis: Diagnosis | str | Path, out: str | Path, command: str = "") -> None:
    """Write a diagnosis, or the file that it was saved in, as one self-contained HTML page, whole or not at all.

    The recordings are read again from their paths, relative paths also from the diagnosis file's folder, and are drawn if
    their hash is still that of the diagnosis. ``command`` is shown as the command that wrote the page. Raises InputError
    for a file that is no diagnosis, and where ``out`` cannot be written.
    """
    check_target(out)
    write_text(out, report_html(diagnosis, command))


def report_html(diagnosis: Diagnosis | str | Path, command: str = "") -> str:
    """The page's text; see ``write_report``."""
    c = diagnosis if isinstance(diagnosis, Diagnosis) else read_diagnosis(diagnosis)
    recordings = reread(c)
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", http_equiv="Content-Security-Policy", content=POLICY),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name="generator", content=f"physident {VERSION}"),
        tag("title", c.headline),
        tag("style", Markup(STYLE)),
    )
    sections = [
        answer(c, recordings, date.today()), joint_errors(c), *causes(c), *lacked_before(c), torques(c, recordings), *evidence(c), unseen(c), advice(c),
        provenance(c, recordings, command),
    ]  # fmt: skip
    return f"<!doctype html>\n{tag('html', head, tag('body', tag('main', *sections)), lang='en')}\n"
