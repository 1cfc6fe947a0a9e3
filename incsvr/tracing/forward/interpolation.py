"""Streams between their stamps: a command holds until the next one, a measurement runs on a line to the next."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.signals.scales import white_noise

Array = NDArray[np.float64]

EVEN = 0.05
"""Of a period that stamps may be off an even grid before they are no longer taken for its edges."""

SPIKE, ABOVE = 6.0, 12.0
"""Times what the neighbours differ, and times the usual bend, by which one sample stands out that is no measurement."""

FAR = 6.0
"""Deviations of a torque's own scatter by which a sample stands out from the median of its neighbours."""


def integral(at: Array, values: Array, until: Array, held: bool) -> Array:
    """Of a stream from its first stamp to each instant: exact where it is held, or linear between its stamps."""
    steps = (values[:-1] if held else 0.5 * (values[1:] + values[:-1])) * np.diff(at)
    total = np.concatenate([[0.0], np.cumsum(steps)])
    index = np.clip(np.searchsorted(at, until, side="right") - 1, 0, max(at.size - 2, 0))
    past = until - at[index]
    if held:
        index = np.clip(np.searchsorted(at, until, side="right") - 1, 0, at.size - 1)
        return np.asarray(total[index] + values[index] * (until - at[index]))
    slope = (values[index + 1] - values[index]) / (at[index + 1] - at[index])
    return np.asarray(total[index] + past * (values[index] + 0.5 * slope * past))


def mean_between(at: Array, values: Array, edges: Array, held: bool) -> Array:
    """(n − 1,) mean of a stream between neighbouring edges (n,)."""
    return np.asarray(np.diff(integral(at, values, edges, held)) / np.diff(edges))


def before(at: Array, values: Array, when: Array) -> Array:
    """The command in force just before each instant: the one of that instant may already answer the rate's next
    rise."""
    return np.asarray(values[np.clip(np.searchsorted(at, when, side="left") - 1, 0, at.size - 1)])


def snapped(edges: Array, clock: Array, step: float) -> Array:
    """The edges, or the stamps themselves where the clock is as even as they are."""
    nearest = clock[np.clip(np.searchsorted(clock, edges - 0.5 * step), 0, clock.size - 1)]
    return nearest if np.max(np.abs(nearest - edges)) < EVEN * step else edges


def rate_at(edges: Array, at: Array, rate: Array, when: Array, torque: Array, inertia: float, held: bool) -> Array:
    """The rate at the edges. Between two of its samples it has a corner wherever the command jumps; what the torque
    leaves of it, r − ∫τ/I₀ dt, has none and is interpolated.
    """
    turned = integral(when, torque, at, held) / inertia
    return np.asarray(np.interp(edges, at, rate - turned) + integral(when, torque, edges, held) / inertia)


def rate_without_spikes(rate: Array) -> Array:
    """The rate with single samples replaced that stand out from neighbours which agree: the top of a fast turn
    stays."""
    if rate.size < 5:
        return rate
    middle = 0.5 * (rate[1:-3] + rate[3:-1])
    bend = np.abs(rate[2:-2] - middle)
    steps = [rate[1:-3] - rate[:-4], rate[4:] - rate[3:-1], rate[3:-1] - rate[1:-3]]
    spike = (bend > SPIKE * np.max(np.abs(steps), axis=0)) & (bend > ABOVE * float(np.median(bend)))
    out = rate.copy()
    out[2:-2][spike] = middle[spike]
    return out


def torque_without_spikes(torque: Array) -> Array:
    """A measured torque with single samples replaced by the median of their neighbourhood of five, where they stand
    out from it: a step of the command stays where it is."""
    if torque.size < 7:
        return torque
    shifted = [np.roll(torque, k) for k in range(-2, 3)]
    calm = np.median(shifted, axis=0)
    calm[:2], calm[-2:] = torque[:2], torque[-2:]
    away = np.abs(torque - calm)
    # where a command runs faster than it scatters most are their own median: the third differences know the scatter
    scatter = white_noise(np.diff(torque, 3))
    spike = away > max(FAR * max(1.4826 * float(np.median(away)), scatter), 0.02 * float(np.std(torque)))
    spike[1:] &= ~(spike[:-1] & (away[:-1] > 0.5 * away[1:]))  # two in a row are no spike
    return np.where(spike, calm, torque)
