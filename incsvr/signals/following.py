"""How wide the filter is at an instant, where no gap is set: as configured, or wide enough for the slower stream.

A torque that holds (holding.py) has no part in it. All follows from the stream's messages up to the instant alone, so
that it is the same whenever it is asked for.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from incsvr.samples import Array
from incsvr.signals.settings import FOLLOWS, TORQUE, WIDER, WIDTH_STEPS, YAW_RATE, SignalSettings
from incsvr.signals.streams import STEPS

Scalar = TypeVar("Scalar", bound=np.generic)


def widenings(
    settings: SignalSettings, held: Mapping[str, tuple[Array, Array]], at: Array, commands: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """(m,) by how many steps of WIDER the filter is widened at the instants `at` [s].

    Args:
        held: name → (stamps [s], values); the last STEPS before each instant must be there.
        commands: (m,) whether the torque is a command that holds, however slowly it comes.
    """
    if settings.gap is not None:
        return np.zeros(at.size, dtype=np.int64)
    period = periods(held[YAW_RATE][0], at)
    period = np.where(commands, period, np.maximum(period, periods(held[TORQUE][0], at)))
    needed = np.log(np.maximum(FOLLOWS * period / settings.smoothing, 1.0)) / np.log(WIDER)
    return np.asarray(np.minimum(np.ceil(needed - 1e-9), WIDTH_STEPS), dtype=np.int64)


def periods(time: Array, at: Array) -> Array:
    """(m,) the stream's period at each instant [s]: the median of the last STEPS steps up to it; 0 where none is."""
    if time.size < 2:
        return np.zeros(at.size)
    steps, counted = recently(np.diff(time), time, at, filled=np.inf)
    median = np.sort(steps, axis=1)[np.arange(at.size), np.maximum(counted - 1, 0) // 2]
    return np.where(counted > 0, median, 0.0)


def recently(
    of_steps: NDArray[Scalar], time: Array, at: Array, filled: float = 0.0
) -> tuple[NDArray[Scalar], NDArray[np.intp]]:
    """(m, STEPS) what is known of a stream's last steps (n − 1,) up to each instant, and how many of them there are.

    Args:
        time: (n,) stamps [s], n at least 2.
        filled: what stands for those before the first.
    """
    padded = np.concatenate((np.full(STEPS, filled).astype(of_steps.dtype), of_steps))
    known = np.searchsorted(time, at, side="right")
    window = np.lib.stride_tricks.sliding_window_view(padded, STEPS)[np.maximum(known - 1, 0)]
    return window, np.clip(known - 1, 0, STEPS)
