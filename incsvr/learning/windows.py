"""The samples around each sample of a stream."""

from __future__ import annotations

import numpy as np

from incsvr.numerics import Array


def windows(streams: Array, count: int) -> Array:
    """(…, n, count) the window of each of (…, n) samples, centred on it but at the ends, where it stays within them.

    Example:
        >>> windows(np.array([1.0, 2.0, 3.0, 4.0]), 3).tolist()
        [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [2.0, 3.0, 4.0], [2.0, 3.0, 4.0]]
    """
    n = streams.shape[-1]
    first = np.minimum(np.maximum(np.arange(n) - count // 2, 0), n - count)
    return np.asarray(streams.take(first[:, None] + np.arange(count), axis=-1))
