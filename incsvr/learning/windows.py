"""The samples around each sample of a stream."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array


def windows(streams: Array, count: int) -> Array:
    """(…, n, count) the window of each of (…, n) samples, centred on it but at the ends, where it stays within them.

    Example:
        >>> windows(np.array([1.0, 2.0, 3.0, 4.0]), 3).tolist()
        [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [2.0, 3.0, 4.0], [2.0, 3.0, 4.0]]
    """
    return np.asarray(streams.take(_places(streams.shape[-1], count), axis=-1))


@lru_cache(maxsize=16)
def _places(n: int, count: int) -> NDArray[np.intp]:
    first = np.minimum(np.maximum(np.arange(n) - count // 2, 0), n - count)
    return np.asarray(first[:, None] + np.arange(count))
