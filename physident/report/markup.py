"""HTML from nested calls, in which every text and every attribute is escaped unless it is markup already."""

from __future__ import annotations

import html

VOID = ("meta", "br")  # elements without an end


class Markup(str):
    """Text that is HTML already; made by ``tag`` and ``joined`` alone."""

    __slots__ = ()


def tag(name: str, /, *children: str, **attributes: str | float) -> Markup:
    """One element; children that are not ``Markup`` are escaped. An attribute's ``_`` is written ``-``, ``class_`` is class."""
    given = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{html.escape(clean(str(value)))}"' for key, value in attributes.items()
    )
    return Markup(f"<{name}{given}>" if name in VOID else f"<{name}{given}>{joined(*children)}</{name}>")


def joined(*children: str) -> Markup:
    """Elements and texts one after another."""
    return Markup("".join(c if isinstance(c, Markup) else html.escape(clean(c)) for c in children))


def table(head: list[str], rows: list[list[str]], **attributes: str) -> Markup:
    """A table that scrolls sideways where it is wider than the page."""
    top = tag("thead", tag("tr", *(tag("th", cell, scope="col") for cell in head)))
    body = tag("tbody", *(_row(head, cells) for cells in rows))
    return tag("div", tag("table", top, body, **attributes), class_="wide")


def _row(head: list[str], cells: list[str]) -> Markup:
    """A row whose cells know their column's name, which a narrow page shows beside them."""
    return tag("tr", *(tag("td", cell, data_label=name) for name, cell in zip(head, cells, strict=True)))


def clean(text: str) -> str:
    """The text with a sign in place of each one that cannot be shown, such as control characters of a file name."""
    return "".join(
        sign if sign.isprintable() or sign in "\n\N{NO-BREAK SPACE}" else "\N{REPLACEMENT CHARACTER}" for sign in text
    )
