"""The form that results have in a notebook: a title, a table of numbers and a closing sentence, as HTML."""

from __future__ import annotations

import re
from collections.abc import Sequence

from markupsafe import Markup, escape

NUMBER = re.compile(r"[-−+]?[\d.]+(e[-+]?\d+)?( ?[±%(].*)?")
CELL = Markup('<{0} style="text-align:{1}">{2}</{0}>')


def results_html(title: str, head: Sequence[str], rows: Sequence[Sequence[object]], note: str = "") -> str:
    """A titled table as HTML; numbers stand on the right, and every text is escaped."""
    top = Markup("").join(
        _cell("th", name, _is_number(column)) for name, column in zip(head, _columns(rows), strict=False)
    )
    lines = [Markup("").join(_cell("td", cell, _is_number(cell)) for cell in row) for row in rows]
    body = Markup("").join(Markup("<tr>{}</tr>").format(line) for line in lines)
    table = (
        Markup("<table><thead><tr>{}</tr></thead><tbody>{}</tbody></table>").format(top, body) if rows else Markup("")
    )
    end = Markup("<p>{}</p>").format(note) if note else Markup("")
    return str(Markup("<div><p><strong>{}</strong></p>{}{}</div>").format(title, table, end))


def _columns(rows: Sequence[Sequence[object]]) -> list[object]:
    """The first cell of each column."""
    return list(rows[0]) if rows else []


def _is_number(cell: object) -> bool:
    """Whether a cell is a number, perhaps with its error or unit; "3 elbow_joint" is a name."""
    return NUMBER.fullmatch(str(cell)) is not None


def _cell(name: str, cell: object, number: bool) -> Markup:
    return CELL.format(name, "right" if number else "left", escape(str(cell)))
