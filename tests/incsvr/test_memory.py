"""How short a memory may be before it is but another inertia."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.effects import Signals, catalogue

MEMORY = catalogue([])["memory/linear"]


def shortest(block: float, scale: float) -> float:
    time = np.linspace(0.0, 10.0, 101)
    signals = Signals(0.1, np.array([0, 101]), time, np.sin(time), np.cos(time), block=block, scale=scale)
    return MEMORY.bounds(signals)[0]


def test_four_blocks_where_blocks_are_short() -> None:
    assert shortest(block=0.07, scale=0.4) == pytest.approx(0.28)


def test_three_quarters_of_the_motion_where_a_noisy_gyro_made_them_long() -> None:
    """Four of these blocks last nearly as long as the motion: a memory of 5 s was taken for an inertia."""
    assert shortest(block=1.34, scale=6.5) == pytest.approx(0.75 * 6.5)
