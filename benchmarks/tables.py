"""Tables that people read."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.tracer.judge import interval


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def share(hits: int, count: int) -> str:
    """A share in per cent with Wilson's 95 % interval."""
    if not count:
        return "–"
    low, high = interval(hits, count)
    return f"{100 * hits / count:.1f} % ({100 * low:.0f}–{100 * high:.0f})"
