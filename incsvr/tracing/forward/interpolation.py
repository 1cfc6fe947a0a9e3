"""Streams between their stamps: a command holds until the next one, the rate runs on a line to the next."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

EVEN = 0.25
"""Of a period that stamps may be off an even grid before they are no longer taken for its edges: a cell's own length is
in its equation, so that jitter within a quarter changes the noise's colour a little, and nothing else."""

SPIKE, ABOVE = 6.0, 12.0
"""Times what the neighbours differ, and times the usual bend, by which one sample stands out that is no measurement."""


def integral(at: Array, values: Array, until: Array) -> Array:
    """Of a command, which holds until the next one, from its first stamp to each instant."""
    total = np.concatenate([[0.0], np.cumsum(values[:-1] * np.diff(at))])
    index = np.clip(np.searchsorted(at, until, side="right") - 1, 0, at.size - 1)
    return np.asarray(total[index] + values[index] * (until - at[index]))


def mean_between(at: Array, values: Array, edges: Array) -> Array:
    """(n − 1,) mean of a stream between neighbouring edges (n,)."""
    return np.asarray(np.diff(integral(at, values, edges)) / np.diff(edges))


def before(at: Array, values: Array, when: Array) -> Array:
    """The command in force just before each instant: the one of that instant may already answer the rate's next
    rise."""
    return np.asarray(values[np.clip(np.searchsorted(at, when, side="left") - 1, 0, at.size - 1)])


def snapped(edges: Array, clock: Array, step: float) -> Array:
    """The edges, or the stamps themselves where the clock is as even as they are."""
    nearest = clock[np.clip(np.searchsorted(clock, edges - 0.5 * step), 0, clock.size - 1)]
    return nearest if np.max(np.abs(nearest - edges)) < EVEN * step else edges


def rate_at(edges: Array, at: Array, rate: Array, when: Array, torque: Array, inertia: float) -> Array:
    """The rate at the edges, without spikes of the gyro. Between two of its samples it has a corner wherever the
    command jumps; what the torque leaves of it, r − ∫τ/I₀ dt, has none and is interpolated.
    """
    torque_rate = integral(when, torque, at) / inertia
    free = without_spikes(rate - torque_rate)
    return np.asarray(np.interp(edges, at, free) + integral(when, torque, edges) / inertia)


def without_spikes(values: Array) -> Array:
    """The values with single samples replaced that stand out of neighbours which lie on a line: the top of a fast turn
    stays, and so does what a controller did about the spike."""
    if values.size < 5:
        return values
    middle = 0.5 * (values[1:-3] + values[3:-1])
    away = np.abs(values[2:-2] - middle)
    slope = 0.5 * (values[3:-1] - values[1:-3])
    beside = [values[1:-3] - values[:-4] - slope, values[4:] - values[3:-1] - slope]
    spike = (away > SPIKE * np.max(np.abs(beside), axis=0)) & (away > ABOVE * float(np.median(away)))
    out = values.copy()
    out[2:-2][spike] = middle[spike]
    return out
