"""Figures of the table, and lines that end at pauses."""

from __future__ import annotations

import numpy as np
import pytest

from viewer.pauses import Pauses
from viewer.texts import quantity


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "-"), (3.14159, "3.14 N m"), (0.0000849, "0.0000849 N m"), (0.0, "0 N m"), (123.4, "123 N m")],
)
def test_a_quantity_is_never_a_power_of_ten(value: float | None, text: str) -> None:
    assert quantity(value, "N m") == text


@pytest.mark.parametrize("cut", [1, 7, 100, 151])
def test_a_line_ends_where_a_pause_begins(cut: int) -> None:
    """However the stream comes in pieces; a slow stream has no pauses of its own."""
    time = np.concatenate((np.arange(0.0, 10.0, 0.1), np.arange(20.0, 30.0, 0.1)))
    pauses, pieces = Pauses(), np.split(time, range(cut, time.size, cut))
    drawn = np.concatenate([np.column_stack(pauses.broken(piece, np.sin(piece))) for piece in pieces])
    ends = drawn[np.isnan(drawn[:, 1]), 0]
    assert ends == pytest.approx([9.9], abs=0.01)
    assert drawn[~np.isnan(drawn[:, 1]), 0] == pytest.approx(time)
    assert np.all(np.diff(drawn[:, 0]) >= 0.0)
    slow = Pauses()
    assert not any(np.isnan(slow.broken(np.array([4.0 * k]), np.zeros(1))[1]).any() for k in range(20))
