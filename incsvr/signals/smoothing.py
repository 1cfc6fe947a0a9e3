"""Differentiation and low-pass filtering of a sampled stream (Section IV-A), for irregular stamps.

Around every wanted instant a straight line is fitted to the stream by least squares, weighted with a Gaussian bell and
with the time that each sample stands for (trapezoid). On regular stamps its slope is the derivative-of-Gaussian filter
and its height the Gaussian filter; on irregular stamps both stay free of bias for a signal that changes linearly.

Spikes are left out first (spikes.py): a sample would be wrong by any amount for the sake of one value.

Like with like: integration by parts turns the slope of r under the bell w(u), cut off at ±W, into the mean of ṙ under
the weights w(u) − w(W). The torque and the yaw rate are averaged with exactly these weights, so that τ and I ṙ have
gone through the same filter before they are subtracted (Eq. 5).

Every result depends on the samples of its own window alone, to the last bit: it makes no difference how many instants
are asked for at once.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.signals.spikes import distances, spikes

HALF_WINDOW_WIDTHS = 3.0
"""Half of the window, in standard deviations of the bell."""
_EDGE_WEIGHT = float(np.exp(-0.5 * HALF_WINDOW_WIDTHS**2))
"""Weight of the bell at the ends of the window, in that of its middle."""
_BLOCK_VALUES = 200_000
"""Values that are filtered at once, about: the memory stays bounded."""


@dataclass(frozen=True, slots=True)
class Smoothed:
    """A stream at the wanted instants; NaN where its window is not complete.

    Attributes:
        value: (m,) the filtered signal, in the stream's unit.
        slope: (m,) its filtered time derivative, in the stream's unit per second.
        spread: (m,) the filter's standard deviation of the signal about its value: how far it moved meanwhile.
        low, high: (m,) the least and the largest value of the window, without its ends and what moves alone.
        step: (m,) the smallest step between two neighbours in it that differ; infinite where none do.
        count, spikes: (m,) how many values it held, and how many of them were left out as spikes.
        period: (m,) the mean time between two of them [s].
        left_out: (k,) stamps of all values that were left out of any window [s], increasing.
    """

    value: Array
    slope: Array
    spread: Array
    low: Array
    high: Array
    step: Array
    count: Array
    spikes: Array
    period: Array
    left_out: Array = field(default_factory=lambda: np.empty(0))

    @property
    def complete(self) -> NDArray[np.bool_]:
        """(m,) whether the window was filled without a gap."""
        return ~np.isnan(self.value)

    def take(self, index: NDArray[np.intp]) -> Smoothed:
        """The stream at some of the instants, by their positions."""
        return Smoothed(*(getattr(self, name)[index] for name in _FIGURES))


_FIGURES = tuple(each.name for each in fields(Smoothed) if each.name != "left_out")


def smooth(time: Array, value: Array, at: Array, *, smoothing: float, gap: float) -> Smoothed:
    """The stream (time, value), filtered and differentiated at the instants `at`.

    Args:
        time: (n,) stamps [s], strictly increasing.
        value: (n,) samples, finite.
        at: (m,) instants [s], increasing.
        smoothing: standard deviation of the Gaussian bell [s]; the window reaches HALF_WINDOW_WIDTHS times as far to
            both sides.
        gap: longest pause between two samples [s], at most 2 · smoothing; a window with a longer one is not complete.
    """
    reach = HALF_WINDOW_WIDTHS * smoothing
    first = np.searchsorted(time, at - reach, side="left")
    last = np.searchsorted(time, at + reach, side="right")
    filled = np.flatnonzero(_covered(time, at, first, last, reach, gap))
    smoothed = nowhere(at.size)
    away = distances(value)
    left_out = []
    # Blocks keep the memory bounded, whatever the rate of the stream.
    ends = np.cumsum(last[filled] - first[filled])
    while filled.size:
        size = max(1, int(np.searchsorted(ends, _BLOCK_VALUES)))
        block, filled = filled[:size], filled[size:]
        ends = ends[size:] - ends[size - 1]
        left_out.append(_lines(time, value, away, at, first, last, block, smoothing, smoothed))
    return replace(smoothed, left_out=np.unique(np.concatenate(left_out))) if left_out else smoothed


def nowhere(count: int) -> Smoothed:
    """A stream of which nothing is known at so many instants."""
    return Smoothed(*np.full((len(_FIGURES), count), np.nan))


def _covered(
    time: Array, at: Array, first: NDArray[np.intp], last: NDArray[np.intp], reach: float, gap: float
) -> NDArray[np.bool_]:
    """Whether each window holds samples from edge to edge without a pause longer than `gap`."""
    if time.size == 0:
        return np.zeros(at.size, dtype=bool)
    pauses = np.zeros(time.size, dtype=np.intp)
    np.cumsum(time[1:] - time[:-1] > gap, out=pauses[1:])
    head, tail = np.minimum(first, time.size - 1), np.maximum(last - 1, 0)
    covered: NDArray[np.bool_] = (
        (last - first >= 3)
        & (pauses[tail] == pauses[head])
        & (time[head] - (at - reach) <= gap)
        & ((at + reach) - time[tail] <= gap)
    )
    return covered


def mean_period(
    time: Array,
    first: NDArray[np.intp],
    last: NDArray[np.intp],
    lost_from: float = 1.5,  # mean steps: half way to the step over one lost message
) -> Array:
    """(m,) the mean step of stamps (n,) from `first` to `last` [s], but for those over a message that was lost."""
    counts = last - first
    mean: Array = (time[last] - time[first]) / np.maximum(counts, 1)
    filled = np.flatnonzero(counts > 0)
    starts = np.cumsum(counts[filled]) - counts[filled]
    index = np.repeat(first[filled] - starts, counts[filled]) + np.arange(counts[filled].sum())
    step = time[index + 1] - time[index]
    lost = step > lost_from * np.repeat(mean[filled], counts[filled])
    if lost.any():
        kept = np.add.reduceat((~lost).astype(np.float64), starts)
        whole = np.add.reduceat(np.where(lost, 0.0, step), starts)
        mean[filled] = np.where(kept < counts[filled], whole / np.maximum(kept, 1.0), mean[filled])
    return mean


def _lines(
    time: Array,
    value: Array,
    away: Array,
    at: Array,
    first: NDArray[np.intp],
    last: NDArray[np.intp],
    block: NDArray[np.intp],
    smoothing: float,
    smoothed: Smoothed,
) -> Array:
    """Fits the lines of the windows of `block` and writes them into `smoothed`; returns the stamps of the spikes."""
    counts = last[block] - first[block]
    starts = np.cumsum(counts) - counts
    ends = starts + counts - 1
    index = np.repeat(first[block] - starts, counts) + np.arange(counts.sum())
    apart, samples = away[index], value[index]
    apart[starts] = apart[ends] = 0.0  # whose neighbours are outside the window
    move = np.empty(samples.size)
    np.abs(samples[1:] - samples[:-1], out=move[:-1])
    move[ends] = 0.0  # from one window to the next
    left_out, alone = spikes(apart, move, starts, counts)
    smoothed.count[block], smoothed.spikes[block] = counts, np.add.reduceat(left_out.astype(np.float64), starts)
    smoothed.period[block] = mean_period(time, first[block], last[block] - 1)
    _extent(samples, move, left_out | alone, starts, ends, block, smoothed)
    aside: Array = time[index[left_out]]
    if left_out.any():
        index, (starts, counts) = index[~left_out], _without(left_out, starts, counts)
        samples = value[index]
    stamps = time[index]
    step = stamps[1:] - stamps[:-1]
    step[starts[1:] - 1] = 0.0  # from one window to the next
    cell = np.zeros(stamps.size)
    cell[1:] = step
    cell[:-1] += step
    offset = stamps - np.repeat(at[block], counts)
    bell = np.exp(-0.5 * (offset / smoothing) ** 2)
    # Differences to a sample of the window itself: a large mean would cost digits.
    level = samples[starts]
    change = samples - np.repeat(level, counts)
    weight = (bell - _EDGE_WEIGHT) * cell
    height, _ = _line(weight, offset, change, starts)
    smoothed.value[block] = level + height
    about = change - np.repeat(height, counts)
    square = np.add.reduceat(weight * about * about, starts) / np.add.reduceat(weight, starts)
    smoothed.spread[block] = np.sqrt(np.maximum(square, 0.0))  # at the very edge a weight is rounded below zero
    _, smoothed.slope[block] = _line(bell * cell, offset, change, starts)
    return aside


def _without(
    left_out: NDArray[np.bool_], starts: NDArray[np.intp], counts: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The begin and length of each window without the values left out, which are never its ends."""
    counts = counts - np.add.reduceat(left_out.astype(np.intp), starts)
    return np.cumsum(counts) - counts, counts


def _extent(
    samples: Array,
    move: Array,
    apart: NDArray[np.bool_],
    starts: NDArray[np.intp],
    ends: NDArray[np.intp],
    block: NDArray[np.intp],
    smoothed: Smoothed,
) -> None:
    """Writes how far the values of each window reach, and its least step, without those that stand apart."""
    apart = apart.copy()
    apart[starts] = apart[ends] = True  # the ends, which no neighbour judges
    smoothed.low[block] = np.minimum.reduceat(np.where(apart, np.inf, samples), starts)
    smoothed.high[block] = np.maximum.reduceat(np.where(apart, -np.inf, samples), starts)
    smoothed.step[block] = np.minimum.reduceat(np.where(move > 0.0, move, np.inf), starts)


def _line(weight: Array, offset: Array, change: Array, starts: NDArray[np.intp]) -> tuple[Array, Array]:
    """Height and slope at offset zero of the weighted least-squares line of each window."""
    products = np.empty((5, weight.size))
    products[0] = weight
    first = np.multiply(weight, offset, out=products[1])
    np.multiply(first, offset, out=products[2])
    np.multiply(weight, change, out=products[3])
    np.multiply(first, change, out=products[4])
    total, mean, spread, height, lean = np.add.reduceat(products, starts, axis=1)
    determinant = total * spread - mean * mean
    return (spread * height - mean * lean) / determinant, (total * lean - mean * height) / determinant
