"""A report's page read back as a browser would: its elements, texts, and the curves of its charts."""

from __future__ import annotations

from dataclasses import dataclass, field
from html.parser import HTMLParser

VOID = {"meta", "br"}


@dataclass
class Element:
    """One element with its attributes, its own text and all that is inside."""

    name: str
    attributes: dict[str, str]
    inside: list[Element | str] = field(default_factory=list)

    def all(self, name: str, kind: str = "") -> list[Element]:
        """Every element of a name inside, of a class where one is given."""
        found = []
        for child in self.inside:
            if isinstance(child, Element):
                own = child.name == name and (not kind or kind in child.attributes.get("class", "").split())
                found += [child] * own + child.all(name, kind)
        return found

    @property
    def text(self) -> str:
        """All text inside, spaces as one."""
        return " ".join(self._text().replace("\N{NO-BREAK SPACE}", " ").split())

    def _text(self) -> str:
        return "".join(child if isinstance(child, str) else child._text() for child in self.inside)


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open = [Element("page", {})]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        element = Element(tag, {key: value or "" for key, value in attrs})
        self.open[-1].inside.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_endtag(self, tag: str) -> None:
        assert self.open[-1].name == tag, f"</{tag}> closes <{self.open[-1].name}>"
        self.open.pop()

    def handle_data(self, data: str) -> None:
        self.open[-1].inside.append(data)


def read_page(html: str) -> Element:
    """The page's elements; fails where they are not closed in order."""
    reader = _Reader()
    reader.feed(html)
    reader.close()
    assert len(reader.open) == 1, f"<{reader.open[-1].name}> stays open"
    return reader.open[0]
