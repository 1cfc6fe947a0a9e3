"""Integrals of a stream between any two instants, and its means over cells of time, exact for its course.

A stream is held, when each value lasts until the stamp of the next, or linear, when a line leads from one value to the
next.
"""

from __future__ import annotations

import numpy as np

from incsvr.numerics.arrays import Array


def running_integral(stamps: Array, values: Array) -> Array:
    """(n,) integral of a linear stream (n,) from its first stamp to each stamp [s]."""
    return np.concatenate(([0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(stamps))))


def integral_at(stamps: Array, values: Array, until: Array, held: bool) -> Array:
    """(m,) integral of a stream (n,), n ≥ 1, from its first stamp to the instants `until` (m,) [s].

    Before the first stamp its first line goes on, after the last one its last value.
    """
    if held:
        total = np.concatenate(([0.0], np.cumsum(values[:-1] * np.diff(stamps))))
    else:
        total = running_integral(stamps, values)
    index = np.clip(np.searchsorted(stamps, until, side="right") - 1, 0, stamps.size - 1)
    past, after = until - stamps[index], np.minimum(index + 1, stamps.size - 1)
    slope = 0.0 if held else (values[after] - values[index]) / np.maximum(stamps[after] - stamps[index], 1e-300)
    return np.asarray(total[index] + past * (values[index] + 0.5 * slope * past))


def cell_means(stamps: Array, values: Array, edges: Array, held: bool) -> Array:
    """(m,) means of a stream (n,), n ≥ 1, over the cells between the edges (m + 1,) [s], strictly increasing."""
    return np.asarray(np.diff(integral_at(stamps, values, edges, held)) / np.diff(edges))
