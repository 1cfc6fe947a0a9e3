"""The instants at which slow streams are known, because they have values close by on either side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array, Streams
from incsvr.signals.coupled import MAX_PAUSE_S

MAX_BRIDGED_PERIODS = 3.0
"""Longest pause of a channel across which it is known, in its usual periods, where that is longer than MAX_PAUSE_S."""


def known_at(time: Array, streams: Streams, names: Sequence[str]) -> NDArray[np.bool_]:
    """(n,) at which instants [s] each of these streams has values close by on either side."""
    known = np.ones(time.size, dtype=bool)
    for name in names:
        stamps = streams[name][0] if name in streams else np.empty(0)
        if stamps.size < 2:
            return np.zeros(time.size, dtype=bool)
        gaps = np.diff(stamps)
        after = np.clip(np.searchsorted(stamps, time), 1, stamps.size - 1)
        close = gaps[after - 1] <= max(MAX_PAUSE_S, MAX_BRIDGED_PERIODS * float(np.median(gaps)))
        known &= (time >= stamps[0]) & (time <= stamps[-1]) & close
    return known
