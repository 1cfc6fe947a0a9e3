"""How wide the filter is at an instant, where no gap is set: as configured, or wide enough for the slower stream.

It follows from the stamps of the stream up to the instant alone, so that it is the same whenever it is asked for.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from incsvr.samples import Array
from incsvr.signals.settings import FOLLOWS, REQUIRED, WIDER, WIDTH_STEPS, SignalSettings
from incsvr.signals.streams import STEPS


def widenings(settings: SignalSettings, held: Mapping[str, tuple[Array, Array]], at: Array) -> NDArray[np.int64]:
    """(m,) by how many steps of WIDER the filter is widened at the instants `at` [s].

    Args:
        held: name → (stamps [s], values); the last STEPS before each instant must be there.
    """
    if settings.gap is not None:
        return np.zeros(at.size, dtype=np.int64)
    period = np.max([_periods(held[name][0], at) for name in REQUIRED], axis=0)
    needed = np.log(np.maximum(FOLLOWS * period / settings.smoothing, 1.0)) / np.log(WIDER)
    return np.asarray(np.minimum(np.ceil(needed - 1e-9), WIDTH_STEPS), dtype=np.int64)


def _periods(time: Array, at: Array) -> Array:
    """(m,) the stream's period at each instant [s]: the median of the last STEPS steps up to it; 0 where none is."""
    if time.size < 2:
        return np.zeros(at.size)
    steps = np.concatenate((np.full(STEPS, np.inf), np.diff(time)))
    known = np.searchsorted(time, at, side="right")
    window = np.sort(np.lib.stride_tricks.sliding_window_view(steps, STEPS)[np.maximum(known - 1, 0)], axis=1)
    counted = np.clip(known - 1, 0, STEPS)
    median = window[np.arange(at.size), np.maximum(counted - 1, 0) // 2]
    return np.where(counted > 0, median, 0.0)
