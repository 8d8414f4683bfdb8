"""A range of a quantity, as a sentence gives it."""

from __future__ import annotations


def range_in_words(low: float, high: float) -> str:
    """The ends of a range, to as many digits as tell them apart."""
    for digits in (2, 3, 4):
        ends = [f"{end:.{digits}g}" for end in (low, high)]
        if ends[0] != ends[1]:
            return f"between {ends[0]} and {ends[1]}"
    return f"at {high:.2g}"
