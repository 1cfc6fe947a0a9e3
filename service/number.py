"""Numbers that a person or a file spells: digits, a point, an exponent; never `350_0`, which Python reads as 3500."""

from __future__ import annotations

import re


def number_of(text: str) -> float:
    """The number that a text is; ValueError where it is none."""
    if "_" in text:
        raise ValueError(f"{text} is no number")
    return float(text)


def whole_number_of(text: str) -> int:
    """The whole number that a text is; ValueError where it is none."""
    if "_" in text:
        raise ValueError(f"{text} is no whole number")
    return int(text)


def decimal_comma(text: str) -> str:
    """The clause on a number whose decimal mark is a comma; empty for all others."""
    if not re.fullmatch(r"[+-]?\d*,\d+", text.strip()):
        return ""
    return f"; its decimal mark is a comma, as in some locales: write {text.strip().replace(',', '.')}"
