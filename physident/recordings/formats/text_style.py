"""How a text file writes its columns: the separator, the decimal sign, the header and the lines before the rows."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass
from pathlib import Path

from physident.errors import InputError
from physident.recordings.formats.table import MAX_COLUMNS

SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", " ": "spaces"}  # the first one in the line counts
MAX_COMMENTS = 1000  # lines before the first row
SAMPLE = 20  # rows that show the decimal sign
BYTE_ORDER_MARK = b"\xef\xbb\xbf"


@dataclass(frozen=True, kw_only=True)
class TextStyle:
    """``skipped`` lines before the first row, ``width`` columns, ``header`` names or None; ``decimal_comma`` as in 0,008."""

    separator: str
    skipped: int
    width: int
    header: tuple[str, ...] | None
    decimal_comma: bool

    def with_commas(self, text: bytes) -> bytes:
        """Whole lines of the file with commas between columns and points in numbers; no line is added or lost."""
        if self.separator == ",":
            return text
        text = text.replace(b",", b"." if self.decimal_comma else b"?")  # 1,000 is not understood beside 0.5
        if self.separator == " ":
            text = re.sub(rb"[ \t]+", b" ", text).replace(b"\n ", b"\n").replace(b" \n", b"\n").strip(b" ")
        return text.replace(self.separator.encode(), b",")


def find_style(path: Path, head: bytes) -> TextStyle:
    """The style of a text file from its beginning; raises InputError for one column, or too many, or lines that are no text.

    A first line without any number is the header. Lines that begin with "#" come before it; the last of them that has as
    many names as the first row has numbers is the header if there is no other.
    """
    lines = re.split(rb"\r\n|\r|\n", head.removeprefix(BYTE_ORDER_MARK))[:MAX_COMMENTS]
    comments = len(list(itertools.takewhile(lambda line: line.startswith(b"#"), lines)))
    above = [line.decode("utf-8", errors="replace").lstrip("# \t").rstrip() for line in lines[:comments]]
    rows = [line.decode("latin-1").strip() for line in lines[comments:]]
    if not rows:
        raise InputError(
            f"{path}: begins with {comments} lines with '#'; expected rows of numbers after under {MAX_COMMENTS}"
        )
    try:
        first = lines[comments].decode("utf-8").strip()
    except UnicodeDecodeError:
        raise InputError(f"{path}: its first line is not UTF-8 text, expected comma-separated numbers") from None
    separator = next((sign for sign in SEPARATORS if sign in first), None)
    if separator is None:
        raise InputError(f"{path}: its first line has one column; expected columns with {_listed()} between them")
    names = _fields(first, separator)
    if len(names) > MAX_COLUMNS:
        raise InputError(f"{path}: {len(names)} columns, expected at most {MAX_COLUMNS}: keep time, q, dq and effort")
    has_header = not any(map(_is_number, names))
    header = tuple(names) if has_header else _commented_header(above, len(names))
    sample = "".join(rows[has_header:SAMPLE])
    return TextStyle(
        separator=separator,
        skipped=comments + has_header,
        width=len(names),
        header=header,
        decimal_comma=separator != "," and "," in sample and "." not in sample,
    )


def _commented_header(comments: list[str], width: int) -> tuple[str, ...] | None:
    """The names in the last comment that has one for each of ``width`` columns, by any separator; or None."""
    for line in reversed(comments):
        for separator in SEPARATORS:
            names = _fields(line, separator)
            if len(names) == width and not any(map(_is_number, names)):
                return tuple(names)
    return None


def _fields(line: str, separator: str) -> list[str]:
    cells = line.split() if separator == " " else line.split(separator)
    return [cell.strip().strip('"') for cell in cells]


def _is_number(text: str) -> bool:
    """Whether a cell is a number, or stands for one that is missing."""
    if text.lower() in ("nan", ""):
        return True
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return "_" not in text


def _listed() -> str:
    *others, last = SEPARATORS.values()
    return f"{', '.join(others)} or {last}"
