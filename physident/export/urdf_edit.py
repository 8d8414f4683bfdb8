"""Replaces the inertia of links and the dynamics of joints in a URDF text; every other byte stays as it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

INDENT = "  "
MARK = "<!-- identified with physident -->"  # by it, a later export knows that it may replace the file


@dataclass
class Element:
    """An element and its position in the encoded text: from ``start`` to ``stop``, with the end tag starting at ``end``.

    An element without an end tag (``<link name="tool0"/>``) has ``end`` equal to ``stop``.
    """

    tag: str
    attributes: dict[str, str]
    start: int
    end: int = 0
    stop: int = 0
    children: list[Element] = field(default_factory=list)

    def find_all(self, tag: str) -> list[Element]:
        """Children of one tag."""
        return [child for child in self.children if child.tag == tag]


@dataclass(frozen=True)
class Edit:
    """Bytes from ``start`` to ``stop`` of an encoded text that ``text`` replaces."""

    start: int
    stop: int
    text: str


def parse_elements(text: str) -> Element:
    """The root element of a well-formed XML text, with the position of every element in its UTF-8 encoding."""
    data = text.encode("utf-8")
    parser = expat.ParserCreate("utf-8")
    top = Element("", {}, 0)
    open_elements = [top]

    def begin(tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, parser.CurrentByteIndex)
        open_elements[-1].children.append(element)
        open_elements.append(element)

    def finish(tag: str) -> None:
        element, at = open_elements.pop(), parser.CurrentByteIndex
        name = tag.encode("utf-8")
        closes = data.startswith(b"</" + name, at) and data[at + 2 + len(name) :][:1] in (
            b">",
            b" ",
            b"\n",
            b"\t",
            b"\r",
        )
        element.end, element.stop = at, data.index(b">", at) + 1 if closes else at

    parser.StartElementHandler, parser.EndElementHandler = begin, finish
    parser.Parse(data, True)
    return top.children[0]


def edit_urdf(text: str, inertials: Mapping[str, str | None], dynamics: Mapping[str, Mapping[str, str]]) -> str:
    """The URDF text with new inertia and dynamics.

    ``inertials`` maps a link's name to its new ``<inertial>`` element, or to None to remove it. ``dynamics`` maps a
    joint's name to the attributes of ``<dynamics>`` to set. All other links and joints keep every byte.
    """
    data = text.encode("utf-8")
    root = parse_elements(text)
    edits: list[Edit] = []
    for link in root.find_all("link"):
        if (name := link.attributes.get("name", "")) in inertials:
            edits += child_edits(data, link, "inertial", inertials[name])
    for joint in root.find_all("joint"):
        if settings := dynamics.get(joint.attributes.get("name", "")):
            old = joint.find_all("dynamics")
            merged = (old[0].attributes if old else {}) | dict(settings)
            written = " ".join(f"{key}={quoteattr(value)}" for key, value in merged.items())
            edits += child_edits(data, joint, "dynamics", f"<dynamics {written}/>")
    return edited(text, edits)


def edited(text: str, edits: Sequence[Edit]) -> str:
    """The text with all edits, which must not overlap."""
    data = text.encode("utf-8")
    for edit in sorted(edits, key=lambda e: e.start, reverse=True):
        data = data[: edit.start] + edit.text.encode("utf-8") + data[edit.stop :]
    return data.decode("utf-8")


def marked(text: str) -> str:
    """An XML text with a comment after its root that says what wrote it, once."""
    if MARK in text:
        return text
    stop = parse_elements(text).stop
    return edited(text, [Edit(stop, stop, f"\n{MARK}")])


def child_edits(data: bytes, parent: Element, tag: str, new: str | None) -> list[Edit]:
    """Edits after which ``new`` is the only child with its tag; None removes all of them."""
    old = parent.find_all(tag)
    if new is None:
        return [_without_line(data, element) for element in old]
    if old:
        margin = _margin(data, old[0].start)
        replaced = Edit(old[0].start, old[0].stop, new.replace("\n", "\n" + margin))
        return [replaced, *(_without_line(data, element) for element in old[1:])]
    outer = _margin(data, parent.start)
    inner = outer + INDENT
    block = f"{inner}{new}".replace("\n", "\n" + inner)
    if parent.end == parent.stop:  # <link name="tool0"/> is opened to hold a child
        slash = data.rindex(b"/", parent.start, parent.stop)
        return [Edit(slash, parent.stop, f">\n{block}\n{outer}</{parent.tag}>")]
    line = data.rfind(b"\n", 0, parent.end) + 1
    if data[line : parent.end].strip():
        return [Edit(parent.end, parent.end, f"\n{block}\n{outer}")]
    return [Edit(line, line, f"{block}\n")]


def _margin(data: bytes, at: int) -> str:
    """The white space before an element, where it is the first on its line."""
    before = data[data.rfind(b"\n", 0, at) + 1 : at]
    return before.decode("utf-8") if not before.strip() else ""


def _without_line(data: bytes, element: Element) -> Edit:
    """The edit that removes an element, including its line where it is alone on it."""
    start = data.rfind(b"\n", 0, element.start) + 1
    stop = data.find(b"\n", element.stop) + 1
    alone = stop > 0 and not data[start : element.start].strip() and not data[element.stop : stop].strip()
    return Edit(start, stop, "") if alone else Edit(element.start, element.stop, "")
