"""The width of the filter at an instant without a configured gap: as configured, or as the slower stream needs.

It is MIN_WIDTH_PERIODS of that stream's period or more, up to MAX_WIDENING times the configured width; pauses are
bridged up to MAX_PAUSE_WIDTHS times its width. A stream at 4 Hz is learned from like this; one slower by far has no
samples.

A torque that holds (holding.py) has no part in it. All follows from the stream's messages up to the instant alone, so
that it is the same whenever it is asked for.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.signals.settings import MAX_WIDENING_STEPS, MIN_WIDTH_PERIODS, WIDENING_FACTOR, SignalSettings
from incsvr.signals.streams import PERIOD_STEPS

Scalar = TypeVar("Scalar", bound=np.generic)


def widenings(settings: SignalSettings, period: Array) -> NDArray[np.int64]:
    """(m,) by how many steps of WIDENING_FACTOR the filter is widened for streams of these periods (m,) [s]."""
    if settings.gap is not None:
        return np.zeros(period.size, dtype=np.int64)
    needed = np.log(np.maximum(MIN_WIDTH_PERIODS * period / settings.smoothing, 1.0)) / np.log(WIDENING_FACTOR)
    return np.asarray(np.minimum(np.ceil(needed - 1e-9), MAX_WIDENING_STEPS), dtype=np.int64)


def periods(time: Array, at: Array) -> Array:
    """(m,) the stream's period at each instant [s]: the median of the last PERIOD_STEPS steps up to it; 0 where none
    is."""
    if time.size < 2:
        return np.zeros(at.size)
    if at.size == 1:  # live, and five times as quick
        known = int(np.searchsorted(time, at[0], side="right"))
        few = np.sort(np.diff(time[max(known - 1 - PERIOD_STEPS, 0) : known]))
        return np.array([few[(few.size - 1) // 2] if few.size else 0.0])
    steps, counted = latest_steps(np.diff(time), time, at, filled=np.inf)
    median = np.sort(steps, axis=1)[np.arange(at.size), np.maximum(counted - 1, 0) // 2]
    return np.where(counted > 0, median, 0.0)


def latest_steps(
    of_steps: NDArray[Scalar], time: Array, at: Array, filled: float = 0.0
) -> tuple[NDArray[Scalar], NDArray[np.intp]]:
    """(m, PERIOD_STEPS) what is known of a stream's last steps (n − 1,) up to each instant, and how many of them
    there are.

    Args:
        time: (n,) stamps [s], n at least 2.
        filled: what stands for those before the first.
    """
    padded = np.concatenate((np.full(PERIOD_STEPS, filled).astype(of_steps.dtype), of_steps))
    known = np.searchsorted(time, at, side="right")
    window = np.lib.stride_tricks.sliding_window_view(padded, PERIOD_STEPS)[np.maximum(known - 1, 0)]
    return window, np.clip(known - 1, 0, PERIOD_STEPS)
