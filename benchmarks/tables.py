"""Tables that people read, and what stands in them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

SIGMAS_OF_95 = 1.96
"""Half width of a band of 95 %, in standard deviations."""


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def page(*parts: str) -> str:
    """A page of Markdown of its paragraphs; those that are empty are left out."""
    return "\n\n".join(part for part in parts if part) + "\n"


def grouped(records: Sequence[Mapping[str, Any]], key: str) -> dict[Any, list[Any]]:
    """The records by what each holds under a key, in the order in which they come."""
    groups: dict[Any, list[Any]] = {}
    for record in records:
        groups.setdefault(record[key], []).append(record)
    return groups


def share(hits: int, count: int) -> str:
    """A share in per cent with Wilson's 95 % interval."""
    if not count:
        return "–"
    low, high = interval(hits, count)
    return f"{100 * hits / count:.1f} % ({100 * low:.0f}–{100 * high:.0f})"


def interval(hits: int, count: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share."""
    if count == 0:
        return 0.0, 1.0
    z, share = SIGMAS_OF_95, hits / count
    middle = (share + z * z / (2 * count)) / (1 + z * z / count)
    half = z / (1 + z * z / count) * math.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    return max(middle - half, 0.0), min(middle + half, 1.0)


def counted(names: Mapping[str, int], most: int | None = None) -> str:
    """The most frequent names with their counts."""
    ranked = sorted(names.items(), key=lambda each: -each[1])[:most]
    return ", ".join(f"{name} {count}" for name, count in ranked if count) or "–"
