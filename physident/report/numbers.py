"""Numbers for readers: three significant digits, a minus sign, powers of ten, a unit."""

from __future__ import annotations

from collections.abc import Sequence

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
SPACE = "\N{NO-BREAK SPACE}"
RAISED = {"^2": "²", "^3": "³", "^a": "ᵃ", " ": SPACE}  # in units


def number(value: float, digits: int = 3, sign: bool = False) -> str:
    """A number with some significant digits: 0.0802, 1.73, −4.2, 5.57·10⁴."""
    size = abs(value)
    if size and (size >= 1e4 or size < 1e-3):
        mantissa, _, power = f"{size:.{digits - 1}e}".partition("e")
        text = f"{mantissa}·10{str(int(power)).translate(SUPERSCRIPT)}"
    else:
        text = f"{size:#.{digits}g}".rstrip(".") if size else "0"
        if size >= 10**digits:
            text = f"{size:.0f}"
    return ("−" if value < 0 else "+" if sign and value > 0 else "") + text


def quantity(value: float, unit: str, digits: int = 3, sign: bool = False) -> str:
    """A number with its unit, on one line; the unit "1" is not written."""
    if unit == "1":
        return number(value, digits, sign)
    for plain, shown in RAISED.items():
        unit = unit.replace(plain, shown)
    return number(value, digits, sign) + SPACE + unit


def arrow(values: Sequence[float], unit: str) -> str:
    """One size after another with their unit: 1.73 → 0.751 N m."""
    *before, last = values
    return " → ".join([*(number(value) for value in before), quantity(last, unit)])


def percent(value: float, sign: bool = False) -> str:
    """A percentage: whole from ten on, else one decimal."""
    text = f"{abs(value):.0f}" if abs(value) >= 9.95 else f"{abs(value):.1f}"
    lead = "" if float(text) == 0 else "−" if value < 0 else "+" if sign else ""
    return f"{lead}{text}{SPACE}%"


def change(before: float, after: float) -> float:
    """Change of a size [%], zero where it was zero before."""
    return 100 * (after / before - 1) if before > 0 else 0.0
