"""Numbers in XML attributes, read strictly: every part of the program sees the same value or the same error."""

from __future__ import annotations

import math
import re
from xml.etree.ElementTree import Element

from physident.errors import InputError

LARGEST = 1e6  # kg, m, kg m^2: more than any arm, and its square does not overflow
SPACE = " \t\r\n"  # what XML calls white space
# Python's float() also reads underscores and the digits of other scripts, which other readers of URDF take for zero
_PLAIN = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


def parse_plain(text: str) -> float:
    """The number that a text is, white space around it aside; NaN where it is none in plain digits."""
    stripped = text.strip(SPACE)
    return float(stripped) if _PLAIN.fullmatch(stripped) else math.nan


def read_number(
    element: Element | None, key: str, where: str, what: str, *, minimum: float = -math.inf, largest: float = LARGEST
) -> float:
    """The number in an attribute; raises InputError, naming ``where`` and ``what``, for any other than a finite one from
    ``minimum`` up whose size is at most ``largest``."""
    text = None if element is None else element.get(key)
    value = math.nan if text is None else parse_plain(text)
    if math.isfinite(value) and value >= minimum and abs(value) <= largest:
        return value
    wanted = "a number of an arm's size" if abs(value) > largest else "a finite number in plain digits"
    wanted += " that is not negative" if minimum == 0 else ""
    xacro = ": run xacro first" if text and "${" in text else ""
    raise InputError(f"{where}: {what} is {text or 'missing'}, expected {wanted}{xacro}")


def read_triple(element: Element | None, key: str, where: str, default: str = "0 0 0") -> tuple[float, float, float]:
    """The three numbers in an attribute, or the ``default``; raises InputError, naming ``where`` and the attribute."""
    text = default if element is None else element.get(key, default)
    values = [parse_plain(part) for part in text.split()]
    if len(values) != 3 or not all(math.isfinite(x) and abs(x) <= LARGEST for x in values):
        raise InputError(f"{where}: {key} is {text!r}, expected three finite numbers in plain digits")
    return values[0], values[1], values[2]
