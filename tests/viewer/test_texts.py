"""Figures of the table, the line of each axis, and lines that end at pauses."""

from __future__ import annotations

import numpy as np
import pytest

from service.wire import Health, StreamHealth
from viewer.health import axes_text
from viewer.pauses import Pauses
from viewer.table import quantity


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "-"), (3.14159, "3.14 N m"), (0.0000849, "0.0000849 N m"), (0.0, "0 N m"), (123.4, "123 N m")],
)
def test_a_quantity_is_never_a_power_of_ten(value: float | None, text: str) -> None:
    assert quantity(value, "N m") == text


def test_each_axis_of_a_vehicle_has_a_line() -> None:
    streams = {"yaw_rate": StreamHealth(received=3, value=0.62)}
    surge = Health(level="STALE", boot="abc", revision=7, learned=0.5, streams=streams)
    lines = axes_text("rov", {"yaw": Health(level="OK", boot="abc"), "surge": surge}).splitlines()
    assert lines[0] == "# rov"
    assert lines[-2:] == [
        "| yaw | OK | learning | - | 0 | 0 % |",
        "| surge | NO DATA | learning | 0.62 m/s | 7 | 50 % |",
    ]


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
