"""A small chart for the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

MARKS = "ox+*"


def chart(curves: Mapping[str, Sequence[float]], top: float, height: int = 12, column: int = 3, first: int = 1) -> str:
    """Curves over `first`, `first` + 1, …: one mark a curve, `#` where two meet, `^` where one leaves the chart.

    Args:
        curves: name → its values, at least one.
        top: largest value that is drawn.
        height: rows.
        column: characters from one point to the next.
        first: where the curves begin.
    """
    low = min(min(values) for values in curves.values())
    high = min(top, max(max(values) for values in curves.values()))
    scale = (height - 1) / (high - low) if high > low else 0.0
    length = max(len(values) for values in curves.values())
    rows = [[" "] * (length * column) for _ in range(height)]
    for mark, values in zip(MARKS, curves.values(), strict=False):
        for k, value in enumerate(values):
            row = rows[height - 1 - round((min(value, high) - low) * scale)]
            place = k * column + column - 1
            row[place] = "^" if value > high else mark if row[place] == " " else "#"
    lines = []
    for number, row in enumerate(rows):
        value = high - number / scale if scale else high
        lines.append(f"{value:7.2f} |{''.join(row)}".rstrip())
    axis = "".join(f"{k:{column}d}" if k % 5 == 0 else " " * column for k in range(first, first + length))
    legend = ", ".join(f"{mark} {name}" for mark, name in zip(MARKS, curves, strict=False))
    return "\n".join([*lines, "        +" + "-" * (length * column), "         " + axis.rstrip(), "         " + legend])
