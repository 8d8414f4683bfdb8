"""The page: one HTML file that needs nothing else, put together from its sections."""

from __future__ import annotations

from pathlib import Path

from physident.diagnosis.result.diagnosis import Diagnosis
from physident.diagnosis.result.saved import read_diagnosis
from physident.diagnosis.result.wording import headline
from physident.files import check_target, write_text
from physident.report.markup import Markup, tag
from physident.report.reread import reread
from physident.report.sections.advice import advice
from physident.report.sections.answer import answer
from physident.report.sections.causes import causes
from physident.report.sections.evidence import evidence
from physident.report.sections.levels import levels
from physident.report.sections.limits import limits
from physident.report.sections.provenance import provenance
from physident.report.sections.torques import torques
from physident.report.stylesheet import STYLE

POLICY = "default-src 'none'; style-src 'unsafe-inline'"  # a browser then fetches and runs nothing, whatever is inside


def write_report(diagnosis: Diagnosis | str | Path, out: str | Path, command: str = "") -> None:
    """Write a diagnosis, or the file it was saved in, as one self-contained HTML page, whole or not at all.

    Its recordings are read again from their paths, relative ones also from the file's folder, and drawn where their hash
    is the one diagnosed. ``command`` is shown as what made the page. Raises InputError for a file that is no diagnosis,
    and where ``out`` cannot be written.
    """
    check_target(out)
    write_text(out, report_html(diagnosis, command))


def report_html(diagnosis: Diagnosis | str | Path, command: str = "") -> str:
    """The page's text; see ``write_report``."""
    c = diagnosis if isinstance(diagnosis, Diagnosis) else read_diagnosis(diagnosis)
    read = reread(c)
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", http_equiv="Content-Security-Policy", content=POLICY),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("title", headline(c.question, c.verdict, c.findings)),
        tag("style", Markup(STYLE)),
    )
    sections = [
        answer(c), levels(c), *causes(c), torques(c, read), *evidence(c), limits(c), advice(c),
        provenance(c, read, command),
    ]  # fmt: skip
    return f"<!doctype html>\n{tag('html', head, tag('body', tag('main', *sections)), lang='en')}\n"
