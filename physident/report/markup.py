"""HTML from nested calls; every text and every attribute is escaped, except what is ``Markup`` already."""

from __future__ import annotations

from markupsafe import Markup, escape

VOID = ("meta", "br", "img")  # elements without an end tag


def tag(name: str, /, *children: str, **attributes: str | float) -> Markup:
    """One element; children that are not ``Markup`` are escaped. In names of attributes ``_`` is written ``-``, and
    ``class_`` is class."""
    given = Markup("").join(
        Markup(' {}="{}"').format(key.rstrip("_").replace("_", "-"), clean(str(value)))
        for key, value in attributes.items()
    )
    start = Markup(f"<{name}{given}>")
    return start if name in VOID else start + joined(*children) + Markup(f"</{name}>")


def joined(*children: str) -> Markup:
    """Elements and texts, one after another."""
    return Markup("").join(child if isinstance(child, Markup) else escape(clean(child)) for child in children)


def table(head: list[str], rows: list[list[str]], **attributes: str) -> Markup:
    """A table that scrolls sideways where it is wider than the page."""
    top = tag("thead", tag("tr", *(tag("th", cell, scope="col") for cell in head)))
    body = tag("tbody", *(_row(head, cells) for cells in rows))
    return tag("div", tag("table", top, body, **attributes), class_="wide")


def _row(head: list[str], cells: list[str]) -> Markup:
    """A row whose cells carry the name of their column, which a narrow page shows beside them."""
    return tag("tr", *(tag("td", cell, data_label=name) for name, cell in zip(head, cells, strict=True)))


def clean(text: str) -> str:
    """The text with a replacement character for each one that cannot be shown, such as control characters."""
    return "".join(
        sign if sign.isprintable() or sign in "\n\N{NO-BREAK SPACE}" else "\N{REPLACEMENT CHARACTER}" for sign in text
    )
